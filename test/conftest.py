"""Shared by unit and scenario tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples in every run of CI; elsewhere new ones are looked for.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("dev", deadline=None)  # a busy machine is no failure
settings.load_profile("ci" if os.environ.get("CI") else "dev")


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder of real recordings; they are not part of the package, so tests skip without them."""
    root = Path(__file__).resolve().parents[1]
    folder = Path(os.environ.get("SAFE_PASSAGE_DATA", root / "../shared/data"))
    if not folder.is_dir():
        pytest.skip("recordings are not here (SAFE_PASSAGE_DATA)")
    return folder
