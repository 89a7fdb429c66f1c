"""Models for the node tests, trained on the exact world of the unit tests in a moment."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "worlds"))
from leg_world import look, walk
from safe_passage.leg_detection.classifiers import save, train
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import from_recording, joined

__all__ = ["look", "make_leg_model"]


def make_leg_model(folder):
    """Path of a model that knows round legs and walls."""
    path = Path(folder) / "legs.model"
    shape = SegmentationParameters()
    walks = joined(from_recording(walk(f"walk {seed}", seed)[0], shape) for seed in range(4))
    save(train("random_forest", walks, shape, "round legs in a square room"), path)
    return path
