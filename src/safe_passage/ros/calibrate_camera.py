"""calibrate_camera: a recording of the arm in some poses -> the camera's pose on the robot."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from safe_passage.calibration import ArmCalibrator, Calibration, CalibrationParameters, Verdict
from safe_passage.calibration.recording import read_folder
from safe_passage.calibration.writers import T_BODY_OPTICAL, pose_of, write
from safe_passage.core.errors import InputError
from safe_passage.core.reading import build, read_yaml
from safe_passage.evaluation.calibration_plots import draw_fit
from safe_passage.robot_model import load_robot_model
from safe_passage.ros.calibration_recordings import read_arm_bag
from safe_passage.ros.packages import package_folder

EPILOG = """
The recording is a bag (one topic of depth images, its camera_info, joint states; the arm stands
still for a second or more in each pose, five poses or more) or a folder (depth_POSE.npy or .png,
joint_states_POSE.npy or .yaml, NAME_camera_info.yaml). Nothing but the robot may be near the arm.
Exit status 1: there is no result, and why is said; nothing is written then but the picture.
"""


def main() -> None:
    """Parse the command line, calibrate, write; exit with 1 where there is no result."""
    args = _arguments()
    values = read_yaml(args.parameters) if args.parameters else {}
    parameters = build(CalibrationParameters, values, str(args.parameters or ""))
    model = load_robot_model(args.urdf, _packages(args.package), parameters.visual)
    share = parameters.least_share
    if args.recording.is_dir():
        recording = read_folder(args.recording, model.movable, share)
    else:
        recording = read_arm_bag(args.recording, model.movable, share)
    _say(f"{len(recording.views)} poses of {model.name}")
    guess = pose_of(args.guess) if args.optical else pose_of(args.guess) @ T_BODY_OPTICAL
    calibrator = ArmCalibrator(model, recording.camera, parameters)
    result = calibrator.calibrate(recording.views, guess)
    args.output.mkdir(parents=True, exist_ok=True)
    picture = args.output / "camera.png"
    draw_fit(model, recording.camera, recording.views, result, picture)
    _say(report(result))
    if result.verdict is not Verdict.OK:
        _say(f"no result, see {picture}")
        sys.exit(1)
    written = write(result, args.output, args.parent or model.root, args.child, args.optical)
    _say("wrote " + ", ".join(str(path) for path in [*written, picture]))


def report(result: Calibration) -> str:
    """What there is to know of a result."""
    lines = [result.why, f"inliers {result.inliers:.2f}"]
    for number, one in enumerate(result.residuals):
        lines.append(f"pose {number}: rms {1e3 * one.rms:.1f} mm, inliers {one.inliers:.2f}")
    if result.observability is not None:
        held = result.observability
        lines.append(f"weakest: {held.weakest} ({held.eigenvalues[0]:.3f} of 0.167)")
    return "\n".join(lines)


def _packages(given: list[str]):  # type: ignore[no-untyped-def]
    """Folders by package name: those given as NAME=FOLDER, else rospack's."""
    known = dict(one.split("=", 1) for one in given)
    return lambda name: Path(known[name]) if name in known else package_folder(name)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="calibrate_camera",
        description=__doc__,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("recording", type=Path, metavar="BAG_OR_FOLDER")
    parser.add_argument("--urdf", type=Path, required=True, metavar="FILE")
    parser.add_argument(
        "--guess",
        type=float,
        nargs=6,
        required=True,
        metavar=("X", "Y", "Z", "ROLL", "PITCH", "YAW"),
        help="the camera's pose in the robot's root frame [m, rad]",
    )
    parser.add_argument("--child", default="camera_link", metavar="FRAME", help="the camera's")
    parser.add_argument("--parent", default="", metavar="FRAME", help="default: the URDF's root")
    parser.add_argument(
        "--optical", action="store_true", help="guess and result are of the optical frame"
    )
    parser.add_argument("--package", nargs="*", default=[], metavar="NAME=FOLDER")
    parser.add_argument("--parameters", type=Path, metavar="YAML")
    parser.add_argument("--output", type=Path, default=Path("calibration"), metavar="FOLDER")
    args = parser.parse_args()
    for one in args.package:
        if "=" not in one:
            raise InputError(f"--package {one}: must be NAME=FOLDER")
    if not np.isfinite(args.guess).all():
        raise InputError(f"--guess {args.guess}: must be finite")
    return args


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
