"""What the doctor says of graphs that are ill in one way each."""

import dataclasses
import math

import numpy as np
import pytest
from safe_passage.doctor.checks import Severity, examine
from safe_passage.doctor.observations import Clock, Frame, Graph, Topic
from safe_passage.simulation.robots import CameraModel, LidarModel, make_robot

MONITOR, TRACKER, DETECTOR = "/separation_monitor", "/obstacle_tracker", "/person_detector"
ROBOT = make_robot(
    {
        "name": "healthy",
        "footprint": [[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]],
        "height": 1.0,
        "drive": {"max_speed": 0.8, "max_turn_rate": 0.8},
        "lidars": [{"name": "laser", "frame": "laser", "x": 0.3, "rate": 20.0}],
        "cameras": [{"name": "camera", "frame": "camera_optical_frame", "rate": 10.0}],
    }
)


def topic(name, kind, **changes) -> Topic:
    values = {
        **{"wanted": kind, "publishers": ("/driver",), "readers": (TRACKER,), "seconds": 5.0},
        **{"count": 100, "frames": ("laser",), "ages": (0.02,) * 100},
    }
    return Topic(name, kind, **{**values, **changes})


def healthy() -> Graph:
    scan = topic("/scan", "sensor_msgs/LaserScan")
    depth = topic(
        "/depth_registered/image_rect", "sensor_msgs/Image", frames=("camera_optical_frame",)
    )
    odom = topic("/odom", "nav_msgs/Odometry", frames=("odom",), readers=(MONITOR,))
    tracks = topic(
        "/tracks",
        "safe_passage/TrackedObstacleArray",
        publishers=(TRACKER,),
        readers=(MONITOR,),
        frames=("base_footprint",),
    )
    out = topic("/cmd_vel", "geometry_msgs/Twist", wanted="", publishers=(MONITOR,), frames=())
    footprint = [[0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]
    return Graph(
        nodes=(MONITOR, TRACKER, DETECTOR),
        expected=(MONITOR, TRACKER),
        topics={one.name: one for one in (scan, depth, odom, tracks, out)},
        frames={
            "laser": Frame("laser", ROBOT.lidars[0].pose_in_base()),
            "camera_optical_frame": Frame("camera", ROBOT.cameras[0].pose_in_base()),
            "odom": Frame("odom", np.eye(4)),
            "base_footprint": Frame("base_footprint", np.eye(4)),
        },
        parameters={
            TRACKER: {"footprint": footprint, "sources": [{"name": "laser", "topic": "scan"}]},
            MONITOR: {"footprint": footprint, "reaction_time": 0.3},
        },
        robot=ROBOT,
    )


def ill(name: str = "", **changes) -> list:
    """Findings of a healthy graph of which one topic, or what else is named, is changed."""
    graph = healthy()
    if name.startswith("/"):
        one = dataclasses.replace(graph.topics[name], **changes)
        changes = {"topics": {**graph.topics, name: one}}
    return examine(dataclasses.replace(graph, **changes))


def only(findings, severity=Severity.FAULT):
    (one,) = findings
    assert one.severity is severity
    return one


def moved(**changes) -> np.ndarray:
    return dataclasses.replace(ROBOT.lidars[0], **changes).pose_in_base()


def with_frame(name, frame) -> dict:
    return {"frames": {**healthy().frames, name: frame}}


def test_of_a_healthy_robot_nothing_is_said():
    assert ill() == []


def test_a_node_that_should_run_is_missed():
    one = only(ill(nodes=(MONITOR, DETECTOR)))
    assert one.subject == TRACKER and "does not" in one.what


def test_a_node_that_was_killed_is_told_from_one_that_never_started():
    one = only(ill(nodes=(MONITOR, DETECTOR), dead=(TRACKER,)))
    assert one.subject == TRACKER and "does not answer" in one.what


def test_an_empty_graph_is_said_to_be_one():
    one = only(examine(Graph()))
    assert "no node" in one.what and "bringup.launch" in one.cause


def test_an_input_that_is_waited_for_is_a_fault_with_what_could_be_meant():
    graph = healthy()
    scan = dataclasses.replace(graph.topics["/scan"], publishers=(), type="", count=0, frames=())
    other = topic("/front/scan", "sensor_msgs/LaserScan", wanted="", readers=())
    said = {TRACKER: (2, "waiting for: /scan")}
    found = examine(
        dataclasses.replace(
            graph,
            topics={**graph.topics, "/scan": scan, "/front/scan": other},
            diagnostics=said,
        )
    )
    first = next(one for one in found if one.subject == "/scan")
    assert first.severity is Severity.FAULT and "/front/scan" in first.cause


def test_an_input_that_no_node_misses_is_only_noted():
    found = ill("/odom", publishers=(), type="", count=0, frames=(), ages=())
    assert only(found, Severity.NOTE).subject == "/odom"


@pytest.mark.parametrize(
    "changes, word",
    [
        ({"type": "sensor_msgs/Range"}, "sensor_msgs/Range"),
        ({"ages": (0.8,) * 9}, "0.80 s old"),
        ({"ages": (-0.4,) * 9}, "future"),
        ({"frames": ("laser", "odom")}, "different frames"),
        ({"frames": ("nowhere",)}, "nowhere"),
        ({"frames": ("",)}, "no frame_id"),
        ({"empty_share": 1.0}, "without one return"),
    ],
)
def test_what_is_wrong_with_a_scan_is_a_fault_and_said(changes, word):
    assert any(
        word in one.what and one.severity is Severity.FAULT for one in ill("/scan", **changes)
    )


def test_a_slow_sensor_is_measured_against_its_yaml():
    one = only(ill("/scan", count=40), Severity.WARNING)
    assert "8.0 Hz" in one.what and "20.0 Hz" in one.what


def test_odometry_has_no_yaml_but_is_needed_often():
    assert "10 Hz are needed" in only(ill("/odom", count=30), Severity.WARNING).what


def test_a_sensor_slower_than_its_time_out_is_told():
    found = ill("/scan", count=15)
    assert any("gives it up" in one.what for one in found)


def test_two_drivers_on_one_topic():
    one = only(ill("/scan", publishers=("/driver", "/old_driver")), Severity.WARNING)
    assert "/old_driver" in one.what


def test_who_drives_past_the_monitor_is_named():
    one = only(ill("/cmd_vel", publishers=(MONITOR, "/joystick")))
    assert "/joystick" in one.what and "drive past" in one.cause


@pytest.mark.parametrize(
    "T, word",
    [
        (moved(x=0.5), "20 cm"),
        (moved(yaw=math.pi), "upside down or backwards"),
    ],
)
def test_a_sensor_that_is_not_where_the_yaml_says(T, word):
    one = only(ill(**with_frame("laser", Frame("laser", T))))
    assert word in one.what + one.cause


def test_a_camera_in_no_optical_frame_is_recognised():
    camera: CameraModel = ROBOT.cameras[0]
    body = camera.pose_in_base()
    body[:3, :3] = np.eye(3)
    one = only(ill(**with_frame("camera_optical_frame", Frame("camera", body))))
    assert "optical" in one.cause


def test_a_frame_that_tf_does_not_know_is_said_with_tfs_words():
    one = only(ill(**with_frame("laser", Frame("laser", error="not part of the same tree"))))
    assert one.subject == "/scan" and "same tree" in one.cause


def test_odometry_that_tf_lacks_or_has_late():
    base = healthy().base_frame
    missing = only(ill(**with_frame(base, Frame(base, error="odom does not exist"))))
    assert missing.subject == "odom -> base_footprint"
    assert "1.00 s old" in only(ill(**with_frame(base, Frame(base, np.eye(4), age=1.0)))).what


@pytest.mark.parametrize(
    "clock, severity",
    [
        (Clock(simulated=True), Severity.FAULT),
        (Clock(simulated=True, publishers=("/bag",), advanced=0.0), Severity.FAULT),
        (Clock(simulated=False, publishers=("/bag",)), Severity.WARNING),
    ],
)
def test_clocks(clock, severity):
    assert only(ill(clock=clock), severity).subject == "/clock"


def test_footprints_that_differ():
    parameters = {**healthy().parameters, MONITOR: {"footprint": [[1, 1], [0, 1], [0, 0]]}}
    assert only(ill(parameters=parameters)).subject == "footprint"


def test_a_reaction_time_shorter_than_the_tracks_take():
    one = only(ill("/tracks", ages=(0.29,) * 100))
    assert one.subject == MONITOR and "0.34 s" in one.what


def test_what_a_node_says_of_itself_is_passed_on():
    one = only(ill(diagnostics={TRACKER: (1, "2 scans dropped")}), Severity.WARNING)
    assert "2 scans dropped" in one.what


def test_nobody_who_drives_now_is_no_fault():
    graph = healthy()
    command = topic("/cmd_vel_raw", "geometry_msgs/Twist", count=0, frames=(), ages=())
    assert (
        examine(dataclasses.replace(graph, topics={**graph.topics, "/cmd_vel_raw": command})) == []
    )


def test_without_a_robots_yaml_nothing_is_compared_with_it():
    lidar: LidarModel = ROBOT.lidars[0]
    assert lidar.rate == 20.0
    assert ill(robot=None, **with_frame("laser", Frame("laser", moved(x=2.0)))) == []
