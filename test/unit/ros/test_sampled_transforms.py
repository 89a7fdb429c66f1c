"""Where tf has gaps, however its messages come in."""

import math

import pytest
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sampled_transforms import SampledTransforms, SampleGaps
from tf2_msgs.msg import TFMessage

LONGEST = 0.2  # [s]


def gaps_of(stamps, parent="base", child="turning"):
    gaps = SampleGaps(LONGEST)
    for stamp in stamps:
        gaps.note(parent, child, stamp)
    return gaps


def test_between_neighbours_that_are_near_there_is_none():
    gaps = gaps_of([1.0, 1.1, 1.2])
    assert all(not gaps.gap("base", "turning", t) for t in (0.5, 1.0, 1.15, 1.2, 9.0))


def test_a_gap_is_told_with_frame_and_length_and_its_ends_are_no_part_of_it():
    gaps = gaps_of([1.0, 2.5])
    assert gaps.gap("base", "turning", 1.7) == "tf of turning was not told for 1.50 s"
    assert gaps.gap("turning", "base", 1.7)
    assert not gaps.gap("base", "turning", 1.0)
    assert not gaps.gap("base", "turning", 2.5)


def test_frames_beside_the_way_do_not_matter():
    gaps = gaps_of([1.0, 2.5], "map", "base")
    for stamp in (1.0, 1.1):
        gaps.note("base", "turning", stamp)
        gaps.note("base", "mast", stamp)
    assert not gaps.gap("mast", "turning", 1.7)
    assert gaps.gap("map", "turning", 1.7)


def test_another_parent_begins_anew():
    gaps = gaps_of([1.0, 2.5])
    gaps.note("trolley", "turning", 2.6)
    assert not gaps.gap("trolley", "turning", 1.7)


def test_a_circle_of_frames_ends():
    gaps = gaps_of([1.0, 2.5], "a", "b")
    gaps.note("b", "a", 1.0)
    gaps.gap("a", "nowhere", 1.7)


def test_forgotten():
    gaps = gaps_of([1.0, 2.5])
    gaps.clear()
    assert not gaps.gap("base", "turning", 1.7)


@given(st.lists(st.integers(0, 40), min_size=1, max_size=30), st.integers(-5, 205))
def test_any_order_tells_the_same(tenths, at):
    stamps, stamp = [0.1 * t for t in tenths], 0.02 * at + 0.005
    before = max((s for s in stamps if s < stamp), default=None)
    after = min((s for s in stamps if s > stamp), default=None)
    told = gaps_of(stamps).gap("base", "turning", stamp)
    within = before is not None and after is not None and after - before > LONGEST + 1e-9
    if within and after - before == pytest.approx(LONGEST):
        return  # rounding decides
    assert bool(told) == within or after - before == pytest.approx(LONGEST)


class Buffer(tf2_ros.BufferCore):
    """tf2's, without its service."""

    def lookup_transform(self, target, source, stamp):
        return self.lookup_transform_core(target, source, stamp)


@pytest.fixture()
def fed(monkeypatch):
    """SampledTransforms without a master, and what it has refused."""
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(1))
    monkeypatch.setattr(tf2_ros, "Buffer", Buffer)
    refused = []
    tf = SampledTransforms(LONGEST, 0.1, lambda outcome, why: refused.append((outcome, why)))
    monkeypatch.setattr(
        tf2_ros.Buffer, "lookup_transform", tf2_ros.BufferCore.lookup_transform_core
    )
    return tf, refused


def told(stamp, x=0.0, w=1.0):
    one = TransformStamped(child_frame_id="turning")
    one.header.frame_id, one.header.stamp = "base", rospy.Time.from_sec(stamp)
    one.transform.translation.x, one.transform.rotation.w = x, w
    return TFMessage([one])


@pytest.mark.parametrize(("x", "w"), [(math.nan, 1.0), (0.0, 0.0), (0.0, 2.0), (0.0, math.inf)])
def test_what_is_no_transform_fills_no_gap(fed, x, w):
    """tf2 drops it: it would interpolate over the whole time."""
    tf, refused = fed
    tf._take(told(0.1), False)
    for stamp in (0.25, 0.4, 0.55):
        tf._take(told(stamp, x, w), False)
    tf._take(told(0.7), False)
    assert [outcome for outcome, _ in refused] == [Outcome.BAD_FIELDS] * 3
    with pytest.raises(tf2_ros.ExtrapolationException, match="turning was not told for 0.60 s"):
        tf.lookup("base", "turning", rospy.Time.from_sec(0.3))
    assert tf.lookup("base", "turning", rospy.Time.from_sec(0.7))


def test_a_transform_from_the_future_is_refused(fed):
    tf, refused = fed
    tf._take(told(1.2), False)
    assert [outcome for outcome, _ in refused] == [Outcome.FUTURE]
