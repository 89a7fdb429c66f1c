"""What the node tests share: transforms, costmaps, diagnostics, and waiting for them."""

import subprocess
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import roslaunch
import roslib.packages
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid

TIMEOUT = 20.0  # s of wall time, for anything awaited
LETHAL = 100  # occupancy of an obstacle's cell
UPRIGHT = Quaternion(0, 0, 0, 1)
OPTICAL = Quaternion(-0.5, 0.5, -0.5, 0.5)  # z ahead, x to the right


def transform(parent, child, stamp, x=0.0, z=0.0, rotation=UPRIGHT):
    """Pose of `child` in `parent`."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, stamp
    message.transform.translation = Vector3(x, 0, z)
    message.transform.rotation = rotation
    return message


class Diagnostics:
    """What one node says in /diagnostics; `news` is notified when it says it."""

    def __init__(self, node, news=None):
        self._prefix = node.strip("/") + ": "
        self._news = news or threading.Condition()
        self._statuses = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._receive)

    def _receive(self, message):
        with self._news:
            for status in message.status:
                name = status.name.lstrip("/")
                if name.startswith(self._prefix):
                    self._statuses[name[len(self._prefix) :]] = status
            self._news.notify_all()

    def level(self, task="inputs"):
        """0 OK, 1 warning, 2 error; -1 before the first report."""
        return self._statuses[task].level if task in self._statuses else -1

    def message(self, task="inputs"):
        """The report's summary."""
        return self._statuses[task].message if task in self._statuses else ""

    def count(self, key, task="inputs"):
        """The number reported under `key`, 0 where there is none."""
        values = self._statuses[task].values if task in self._statuses else []
        return int({pair.key: pair.value for pair in values}.get(key, 0))

    def __str__(self):
        return "; ".join(
            f"{task}: {status.message} { {v.key: v.value for v in status.values} }"
            for task, status in self._statuses.items()
        )


class CostmapView:
    """A costmap as its subscribers put it together, from whole maps and updates of a part."""

    def __init__(self, topic, news):
        self._news = news
        self.grid, self.header, self.info = None, None, None
        self.whole_maps = self.maps = 0
        rospy.Subscriber(topic, OccupancyGrid, self._on_map)
        rospy.Subscriber(topic + "_updates", OccupancyGridUpdate, self._on_update)

    def _on_map(self, message):
        with self._news:
            cells = np.array(message.data, dtype=np.int8)
            self.grid = cells.reshape(message.info.height, message.info.width)
            self.header, self.info = message.header, message.info
            self.whole_maps += 1
            self.maps += 1
            self._news.notify_all()

    def _on_update(self, message):
        with self._news:
            if self.grid is not None:
                patch = np.array(message.data, np.int8).reshape(message.height, message.width)
                x, y = message.x, message.y
                self.grid[y : y + message.height, x : x + message.width] = patch
                self.header = message.header
            self.maps += 1
            self._news.notify_all()

    def lethal(self):
        """Centres (N, 2) of the lethal cells [m], in the map's frame."""
        with self._news:
            if self.grid is None:
                return np.empty((0, 2))
            corner = self.info.origin.position
            cells = np.argwhere(self.grid == LETHAL)[:, ::-1] + 0.5
            return cells * self.info.resolution + (corner.x, corner.y)


def wait_until(news, reached, what, step=None):
    """Wait for `reached`; `step` is called meanwhile, some times a second."""
    end = time.monotonic() + TIMEOUT
    while True:
        with news:
            if news.wait_for(reached, 0.2 if step else TIMEOUT):
                return
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain for {what() if callable(what) else what}")
        if step:
            step()


def launch_for(test, *files):
    """Start (FILE, ARGUMENTS) for a class of tests: for those that write what is launched."""
    run = rospy.get_param("/run_id")
    launched = roslaunch.parent.ROSLaunchParent(run, list(files), is_core=False)
    launched.start(auto_terminate=False)
    test.addClassCleanup(launched.shutdown)


def folder_for(test):
    """A new folder that goes when a class of tests is done, after what was launched since."""
    folder = tempfile.TemporaryDirectory()
    test.addClassCleanup(folder.cleanup)
    return Path(folder.name)


def output_of_refusal(program, *arguments):
    """What a node of this package prints before it exits with 1."""
    path, *_ = roslib.packages.find_node("safe_passage", program)  # python: the source comes last
    done = subprocess.run([path, *arguments], capture_output=True, text=True, timeout=TIMEOUT)
    output = done.stdout + done.stderr
    if done.returncode != 1:
        raise AssertionError(f"{program} exited with {done.returncode}, not 1:\n{output}")
    return output
