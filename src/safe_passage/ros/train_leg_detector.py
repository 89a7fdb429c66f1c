"""train_leg_detector: recordings -> a model for the leg detector, with its cross-validation."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from safe_passage.evaluation.leg_tables import as_markdown, table_1
from safe_passage.leg_detection.classifiers import CLASSIFIERS, save, train
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import (
    LEG,
    OTHER,
    UNKNOWN,
    LabelledSegments,
    from_recording,
    joined,
)
from safe_passage.ros.leg_recordings import read_negative, read_positive

NEGATIVE_BLOCKS = 6  # stretches of time that a negative bag is cut into for cross-validation
TIMED_SCANS = 200  # how many scans are timed
EPILOG = """
Positive bags: one topic of sensor_msgs/LaserScan, one of geometry_msgs/PoseArray whose n-th message
has the legs of the n-th scan, in the scanner's frame; the scanner stands still. Negative bags: any
number of LaserScan topics, recorded where nobody was. Record them where the robot will work: a
model knows little beyond the scanner and the rooms that it was trained on.
"""


def read_bags(
    positive: list[Path], negative: list[Path], segmentation: SegmentationParameters
) -> tuple[LabelledSegments, list[Scan]]:
    """Labelled segments of all bags, and the scans of the first positive one."""
    parts, scans = [], []
    for path in positive:
        recording = read_positive(path)
        parts.append(from_recording(recording, segmentation))
        scans = scans or list(recording.scans)
        _say(f"{path.name}: {_counts(parts[-1])}")
    for path in negative:
        one = joined(from_recording(r, segmentation, NEGATIVE_BLOCKS) for r in read_negative(path))
        parts.append(one)
        _say(f"{path.name}: {_counts(one)}")
    return joined(parts), scans


def main() -> None:
    """Parse the command line, train, print, save."""
    args = _arguments()
    segmentation = SegmentationParameters(jump_distance=args.jump_distance)
    segments, scans = read_bags(args.positive, args.negative, segmentation)
    bags = ", ".join(path.name for path in [*args.positive, *args.negative])
    model = train(args.classifier, segments, segmentation, bags)
    save(model, args.output)
    _say(f"wrote {args.output}: {args.classifier}, trained on all of it")
    if not args.no_table:
        _say("cross-validation, each recording judged by a model of the others:")
        names = CLASSIFIERS if args.all else [args.classifier]
        print(as_markdown(table_1(segments, scans[:TIMED_SCANS], segmentation, names, _say)))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="train_leg_detector",
        description=__doc__,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--positive", type=Path, nargs="+", required=True, metavar="BAG")
    parser.add_argument("--negative", type=Path, nargs="*", default=[], metavar="BAG")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE")
    parser.add_argument("--classifier", default="random_forest", choices=CLASSIFIERS)
    parser.add_argument(
        "--jump-distance", type=float, default=SegmentationParameters.jump_distance, metavar="M"
    )
    parser.add_argument("--all", action="store_true", help="every classifier in the table")
    parser.add_argument("--no-table", action="store_true", help="no cross-validation")
    return parser.parse_args()


def _counts(segments: LabelledSegments) -> str:
    return (
        f"{segments.count(LEG)} legs, {segments.count(OTHER)} others, "
        f"{segments.count(UNKNOWN)} segments of unknown truth (not used)"
    )


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
