#!/usr/bin/env python3
"""Every rviz file, in the real rviz: its displays load, subscribe, and draw what the chain says."""

import os
import re
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np
import rosgraph
import rospkg
import rospy
import rostest
import tf2_ros
import yaml
from node_testing import transform, wait_until

VIEWS = sorted(Path(rospkg.RosPack().get_path("safe_passage")).glob("rviz/*.rviz"))
TOPIC_KEYS = "Topic", "Marker Topic", "Image Topic"
COMPLAINTS = re.compile("error|fatal|fail|could not|exception", re.IGNORECASE)
KNOWN = re.compile(
    # rviz looks for plugins of a package that is nowhere packaged any more
    r"\[rospack\] Error: no such package media_export\n\[librospack\]: error while executing.*"
    # rviz's Map with this OGRE (ros2/rviz issue 951); the map is drawn all the same
    r"|\[ERROR\].*rviz/glsl120/indexed_8bit_image\.vert\nrviz/glsl120/indexed_8bit_image\.frag"
    r"\n GLSL link result : \nactive samplers with a different type refer to the same texture"
)
SCREEN = 1600, 1000  # px
LEAST_PIXELS = 50  # of a colour that is drawn
END_TIMEOUT = 10.0  # s of wall time


class Screen:
    """An X server of its own on a free display, its picture in a file."""

    def __init__(self, folder):
        self._picture = Path(folder) / "Xvfb_screen0"
        reader, writer = os.pipe()
        size = "x".join(map(str, (*SCREEN, 24)))
        # Without Xvfb this raises FileNotFoundError: the test fails.
        command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", size, "-fbdir", str(folder)]
        self._server = subprocess.Popen(
            [*command, "-nolisten", "tcp"], pass_fds=[writer], stderr=subprocess.DEVNULL
        )
        os.close(writer)
        with os.fdopen(reader) as answer:
            self.display = ":" + answer.readline().strip()

    def count(self, rgb):
        """Pixels of exactly this colour."""
        data = self._picture.read_bytes()  # XWD: a header, a colour table, the pixels as BGRx
        header = np.frombuffer(data, ">u4", 25)
        width, height, row = int(header[4]), int(header[5]), int(header[12])
        start = int(header[0]) + 12 * int(header[19])
        rows = np.frombuffer(data, np.uint8, height * row, start).reshape(height, row)
        pixels = rows[:, : 4 * width].reshape(height, width, 4)
        return int((pixels[..., :3] == rgb[::-1]).all(axis=-1).sum())

    def close(self):
        end(self._server)


def end(process):
    process.terminate()
    try:
        process.wait(END_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def colour(text):
    return tuple(int(part) for part in text.split(";"))


def enabled_displays(view):
    return list(enabled_in(view["Visualization Manager"]["Displays"]))


def enabled_in(displays):
    """Those of groups too, if the group is."""
    for display in displays:
        if display["Enabled"] and display["Class"] == "rviz/Group":
            yield from enabled_in(display["Displays"])
        elif display["Enabled"]:
            yield display


def topics_of(view):
    return {"/" + d[key] for d in enabled_displays(view) for key in TOPIC_KEYS if key in d}


def drawn_colours(view):
    """The background, and the colour of the last scan, which no other scan paints over."""
    scans = [colour(d["Color"]) for d in enabled_displays(view) if d["Class"] == "rviz/LaserScan"]
    background = view["Visualization Manager"]["Global Options"]["Background Color"]
    return [colour(background), *scans[-1:]]


def subscriptions(node):
    _, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return {topic for topic, nodes in subscribers if node in nodes}


class RvizFilesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """The replayed robot has no map: views of a simulated one find theirs where it started."""
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        cls.broadcaster.sendTransform(transform("map", "odom", rospy.Time.now()))

    def test_every_view_opens(self):
        self.assertGreater(len(VIEWS), 0)
        for path in VIEWS:
            with tempfile.TemporaryDirectory() as folder:
                screen = Screen(folder)
                try:
                    self.open_view(path, screen, Path(folder))
                finally:
                    screen.close()

    def open_view(self, path, screen, folder):
        node = f"/opens_{path.stem}"
        log = folder / "log"
        with log.open("w") as output:
            rviz = subprocess.Popen(
                ["rosrun", "rviz", "rviz", "-d", str(path), f"__name:={node[1:]}"],
                stdout=output,
                stderr=subprocess.STDOUT,
                env={
                    **os.environ,
                    "DISPLAY": screen.display,
                    "LIBGL_ALWAYS_SOFTWARE": "1",
                    "XDG_RUNTIME_DIR": str(folder),
                    "HOME": str(folder),  # rviz's own settings are not the user's
                },
            )
        try:
            self.wait_until_drawn(rviz, node, yaml.safe_load(path.read_text()), screen, log)
        finally:
            end(rviz)
        said = KNOWN.sub("", log.read_text())
        self.assertIsNone(COMPLAINTS.search(said), f"{path}: {said}")

    def wait_until_drawn(self, rviz, node, view, screen, log):
        """Wait until rviz has subscribed to all topics and drawn the view's colours."""
        topics, colours = topics_of(view), drawn_colours(view)

        def state():
            missing = topics - subscriptions(node)
            counts = {rgb: screen.count(rgb) for rgb in colours}
            return f"{node}: topics without it: {missing}; pixels: {counts}; {log.read_text()}"

        def drawn():
            self.assertIsNone(rviz.poll(), f"{node} ended: {log.read_text()}")
            return topics <= subscriptions(node) and all(
                screen.count(rgb) > LEAST_PIXELS for rgb in colours
            )

        wait_until(threading.Condition(), drawn, state, lambda: None)


if __name__ == "__main__":
    rospy.init_node("test_rviz_files")
    rostest.rosrun("safe_passage", "test_rviz_files", RvizFilesTest, sys.argv)
