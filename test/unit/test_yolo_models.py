"""YOLO models of every family run through OpenCV: made here, so that their answer is known.

Each model sees one box everywhere: 64 x 96 px around the middle of a 256 x 192 input, probability
0.8, class person.
"""

import struct

import cv2
import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper
from safe_passage import _person_detection as detection

WIDTH, HEIGHT = 256, 192  # [px] of the input
CELLS = (HEIGHT // 32) * (WIDTH // 32)
BOX = [WIDTH / 2, HEIGHT / 2, 64.0, 96.0]  # cx, cy, w, h [px]


def constant_network(channels, tail, outputs):
    """A convolution of stride 32 that answers `channels` in every cell, then `tail`."""
    nodes = [
        helper.make_node(
            "Conv", ["image", "w", "b"], ["map"], kernel_shape=[32, 32], strides=[32, 32]
        )
    ]
    weights = [
        helper.make_tensor(
            "w",
            TensorProto.FLOAT,
            [len(channels), 3, 32, 32],
            np.zeros(len(channels) * 3 * 32 * 32, np.float32),
        ),
        helper.make_tensor("b", TensorProto.FLOAT, [len(channels)], np.float32(channels)),
        helper.make_tensor("rows", TensorProto.INT64, [3], [1, len(channels), CELLS]),
    ]
    graph = helper.make_graph(
        nodes + tail,
        "constant",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, HEIGHT, WIDTH])],
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in outputs],
        weights,
    )
    opset = [helper.make_opsetid("", 12)]
    return helper.make_model(graph, opset_imports=opset, ir_version=7)


def yolov8():
    """1 x (4 + 2) x N."""
    tail = [helper.make_node("Reshape", ["map", "rows"], ["out"])]
    return constant_network([*BOX, 0.8, 0.1], tail, [("out", [1, 6, CELLS])])


def yolov5():
    """1 x N x (5 + 2), objectness 1."""
    tail = [
        helper.make_node("Reshape", ["map", "rows"], ["flat"]),
        helper.make_node("Transpose", ["flat"], ["out"], perm=[0, 2, 1]),
    ]
    return constant_network([*BOX, 1.0, 0.8, 0.1], tail, [("out", [1, CELLS, 7])])


def yolov8_heads():
    """1 x (64 + 2) x rows x columns: every distance one cell, boxes of 64 x 64 px everywhere."""
    bins = np.full((4, 16), -20.0)
    bins[:, 1] = 20.0
    logit = np.log(0.8 / 0.2)
    tail = [helper.make_node("Identity", ["map"], ["out"])]
    shape = [1, 66, HEIGHT // 32, WIDTH // 32]
    return constant_network([*bins.ravel(), logit, -20.0], tail, [("out", shape)])


def detect(tmp_path, model, image, **parameters):
    path = tmp_path / "model.onnx"
    onnx.save(model, str(path))
    values = detection.YoloParameters()
    values.model, values.input_width, values.input_height = str(path), WIDTH, HEIGHT
    for name, value in parameters.items():
        setattr(values, name, value)
    return detection.YoloConfidence(values).detect(image)


IMAGE = np.zeros((480, 640, 3), np.uint8)  # 2.5 times the input


@pytest.mark.parametrize("family", ["auto", "named"])
@pytest.mark.parametrize("make", [yolov5, yolov8])
def test_families_recognised_or_named_give_the_box_in_image_pixels(tmp_path, make, family):
    named = "auto" if family == "auto" else make.__name__
    boxes = detect(tmp_path, make(), IMAGE, family=named)
    assert len(boxes) == 1  # 48 equal boxes, suppressed to one
    assert boxes[0] == pytest.approx((240.0, 120.0, 160.0, 240.0, 0.8), rel=1e-3)


def test_heads_give_a_box_a_cell(tmp_path):
    boxes = detect(tmp_path, yolov8_heads(), IMAGE)
    assert len(boxes) == CELLS  # neighbours overlap by less than the suppression's limit
    assert (boxes[0][2], boxes[0][3]) == pytest.approx((160.0, 160.0), rel=1e-3)
    assert all(box[4] == pytest.approx(0.8, rel=1e-3) for box in boxes)


def test_another_class_is_not_a_person(tmp_path):
    boxes = detect(tmp_path, yolov8(), IMAGE, person_class=1)
    assert all(box[4] == pytest.approx(0.1, rel=1e-3) for box in boxes)


def test_wrong_family_class_or_size_is_an_error_that_names_the_parameter(tmp_path):
    with pytest.raises(RuntimeError, match="yolo/family"):
        detect(tmp_path, yolov8(), IMAGE, family="yolov8_heads")
    with pytest.raises(RuntimeError, match="yolo/family is 'yolov99'"):
        detect(tmp_path, yolov8(), IMAGE, family="yolov99")
    with pytest.raises(RuntimeError, match="yolo/family"):
        detect(tmp_path, yolov8(), IMAGE, person_class=7)
    with pytest.raises(RuntimeError, match="multiples of 32"):
        detect(tmp_path, yolov8(), IMAGE, input_width=250)
    with pytest.raises(RuntimeError, match="yolo/backend"):
        detect(tmp_path, yolov8(), IMAGE, backend="abacus")
    with pytest.raises(RuntimeError, match="yolo/target"):
        detect(tmp_path, yolov8(), IMAGE, target="abacus")


def test_missing_cuda_is_an_error_not_a_silent_fall_back_to_the_cpu(tmp_path):
    if cv2.cuda.getCudaEnabledDeviceCount():
        detect(tmp_path, yolov8(), IMAGE, backend="cuda", target="cuda")
        return
    with pytest.raises(RuntimeError, match="no cuda with cuda"):
        detect(tmp_path, yolov8(), IMAGE, backend="cuda", target="cuda")


CFG = """[net]
width=64
height=64
channels=3

[convolutional]
batch_normalize=1
filters=4
size=32
stride=32
pad=0
activation=leaky

[convolutional]
filters=18
size=1
stride=1
activation=linear

[yolo]
mask = 0,1,2
anchors = 10,14, 23,27, 37,58
classes=1
num=3
"""
NUMBERS = 4 * 4 + 4 * 3 * 32 * 32 + 18 + 18 * 4  # normalisations, kernels, biases


def darknet(tmp_path, head, weights, cfg=CFG):
    """One frame through a darknet model."""
    (tmp_path / "tiny.cfg").write_text(cfg)
    (tmp_path / "tiny.weights").write_bytes(head + weights)
    values = detection.YoloParameters()
    values.model, values.input_width, values.input_height = str(tmp_path / "tiny.weights"), 64, 64
    return detection.YoloConfidence(values).detect(IMAGE)


OLD, NEW = struct.pack("<4i", 0, 1, 0, 0), struct.pack("<3iq", 0, 2, 5, 0)


@pytest.mark.parametrize("head", [OLD, NEW])
def test_darknet_weights_are_read_whole(tmp_path, head):
    numbers = np.ones(NUMBERS, np.float32)
    numbers[4:] = 0.0
    assert len(darknet(tmp_path, head, numbers.tobytes())) == 12  # four cells of three equal boxes


@pytest.mark.parametrize("off", [-4 * NUMBERS, -4000, -4, -1, 1, 4])
def test_weights_cut_off_or_of_another_config_are_refused(tmp_path, off):
    """OpenCV itself takes what was in memory for what is not in the file."""
    weights = bytes(max(0, 4 * NUMBERS + off))[: 4 * NUMBERS] + bytes(max(0, off))
    with pytest.raises(RuntimeError, match="tiny.weights has .* bytes, its config is of"):
        darknet(tmp_path, NEW, weights)
