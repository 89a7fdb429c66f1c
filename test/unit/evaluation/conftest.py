"""One sampler for all: to build the scene takes a second."""

import pytest
from eval_worlds import SETTING
from safe_passage.evaluation.views import ViewSampler


@pytest.fixture(scope="session")
def sampler():
    made = ViewSampler(*SETTING.load())
    yield made
    made.close()
