"""The detector model's set-up."""

import pytest
from safe_passage.core.errors import InputError
from safe_passage.human_safety import models

FAULTY = "[yolo]\nmask = 3,4,5\n\n[yolo]\nmask = 0,1,2\nanchors = 1\n"


def test_only_the_last_mask_is_mended():
    assert (
        models.corrected_cfg(FAULTY)
        == "[yolo]\nmask = 3,4,5\n\n[yolo]\nmask = 1,2,3\nanchors = 1\n"
    )


def test_mended_stays_mended():
    assert models.corrected_cfg(models.corrected_cfg(FAULTY)) == models.corrected_cfg(FAULTY)


@pytest.mark.parametrize("text", ["", "[net]\n", "[yolo]\nmask = 6,7,8\n"])
def test_another_network_is_refused(text):
    with pytest.raises(InputError, match="last layer"):
        models.corrected_cfg(text)


def test_missing_package_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(models, "PACKAGE", "no_such_package")
    with pytest.raises(InputError, match="no_such_package"):
        models.install_yolov3_tiny(tmp_path)


def test_wrong_weights_are_refused(monkeypatch, tmp_path):
    package = tmp_path / "wrong_weights"
    (package / "mlmodels").mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "mlmodels" / "yolov3-tiny.weights").write_bytes(b"not the weights")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(models, "PACKAGE", "wrong_weights")
    with pytest.raises(InputError, match="SHA-256"):
        models.install_yolov3_tiny(tmp_path / "models")
    assert not (tmp_path / "models").exists()
