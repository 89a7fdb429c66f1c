"""A 2D scanner that turns in a known room: its scans, angles, and the truth."""

import math

import numpy as np
import rospy
from safe_passage.evaluation.segmentation_places import room
from safe_passage.ros.conversions import to_header, to_transform
from safe_passage.scan_segmentation.assembling import MOUNT
from safe_passage.scan_segmentation.scan import to_cartesian
from safe_passage.simulation.scan_scene import Scanner, cast
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Header

LINES = 60  # a revolution
PERIOD = 1.0 / 37.5  # s
BEAMS = 45  # over half a turn, 4 degrees each: the upper half is used
PLACE = room()
SCANNER = Scanner(position=(0.0, 0.0, 1.2))
ALPHA = np.radians(-90.0 + 4.0 * np.arange(BEAMS))


def angles(number):
    """(W,) [rad] of the platform at each beam of line `number`: it turns within a line, too."""
    return 2.0 * math.pi / LINES * (number + 0.5 * np.arange(BEAMS) / BEAMS)


def ranges(number):
    """(W,) [m] exact."""
    beta = angles(number)
    unit = np.stack(
        [to_cartesian(np.ones((1, 1)), ALPHA[[k]], beta[[k]])[0, 0] for k in range(BEAMS)]
    )
    exact, _ = cast(PLACE, np.array(SCANNER.position), unit @ SCANNER.rotation().T)
    return exact


def truth(number):
    """(W / 2, 3) [m] of the beams that are used."""
    beta, distance = angles(number), ranges(number)
    used = np.nonzero((ALPHA > -1e-6) & (math.pi / 2 - 1e-3 > ALPHA))[0]
    return np.stack([to_cartesian(distance[None, [k]], ALPHA[[k]], beta[[k]])[0, 0] for k in used])


def scan(number, stamp, frame="laser"):
    """The line as LaserScan, its first beam at `stamp`."""
    message = LaserScan(header=Header(frame_id=frame, stamp=stamp))
    message.angle_min, message.angle_increment = ALPHA[0], ALPHA[1] - ALPHA[0]
    message.angle_max = ALPHA[-1]
    message.time_increment, message.scan_time = 0.5 * PERIOD / BEAMS, PERIOD
    message.range_min, message.range_max = 0.05, 30.0
    message.ranges = ranges(number % LINES).tolist()
    message.intensities = [float(number % LINES)] * BEAMS
    return message


def joint(number, stamp):
    """The encoder's message at the line's first beam; it begins anew at a whole turn."""
    position = (2.0 * math.pi / LINES * number) % (2.0 * math.pi)
    return JointState(Header(stamp=stamp), ["other", "platform"], [0.0, position], [], [])


def laser(number, stamp):
    """tf of the scanner at the line's first beam."""
    beta = 2.0 * math.pi / LINES * number
    c, s = math.cos(beta), math.sin(beta)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ MOUNT[:3, :3]
    return to_transform(to_header(stamp, "scanner"), "laser", np.zeros(3), turned)


def stamp_of(number, begin):
    """Of line `number`."""
    return rospy.Time.from_sec(begin + number * PERIOD)
