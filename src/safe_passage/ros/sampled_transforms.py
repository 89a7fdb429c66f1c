"""tf of which is known where it has gaps: what turns must not be interpolated across them."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Callable

import rospy
import tf2_ros
from tf2_msgs.msg import TFMessage

from safe_passage.ros.conversions import is_transform
from safe_passage.ros.diagnostics import Outcome

MOST_GAPS = 200  # remembered of a frame


@dataclass
class _Samples:
    """When a frame's transform was told, as far as that matters."""

    parent: str
    first: float  # [s]
    last: float  # [s]
    gaps: deque  # of (begin, end) [s]


class SampleGaps:
    """Where the transforms between two frames are farther apart than they may be.

    Args:
        longest: [s] between two transforms of a frame.
    """

    def __init__(self, longest: float) -> None:
        self._longest = longest
        self._frames: dict[str, _Samples] = {}

    def note(self, parent: str, child: str, stamp: float) -> None:
        """A transform of `child` at `stamp` [s]."""
        known = self._frames.get(child)
        if known is None or known.parent != parent:
            self._frames[child] = _Samples(parent, stamp, stamp, deque(maxlen=MOST_GAPS))
            return
        for gap in [gap for gap in known.gaps if gap[0] < stamp < gap[1]]:
            known.gaps.remove(gap)
            self._keep(known, gap[0], stamp)
            self._keep(known, stamp, gap[1])
        if stamp > known.last:
            self._keep(known, known.last, stamp)
        elif stamp < known.first:
            self._keep(known, stamp, known.first)
        known.first, known.last = min(known.first, stamp), max(known.last, stamp)

    def gap(self, frame: str, other: str, stamp: float) -> str:
        """Where between the frames `stamp` [s] lies in a gap; empty: nowhere."""
        paths = self._to_root(frame), self._to_root(other)
        for child in set(paths[0]) ^ set(paths[1]):  # what both have does not matter
            known = self._frames.get(child)
            for begin, end in known.gaps if known else ():
                if begin < stamp < end:
                    return f"tf of {child} was not told for {end - begin:.2f} s"
        return ""

    def clear(self) -> None:
        """Forget all."""
        self._frames.clear()

    def _keep(self, known: _Samples, begin: float, end: float) -> None:
        if end - begin > self._longest:
            known.gaps.append((begin, end))

    def _to_root(self, frame: str) -> list[str]:
        path = [frame]
        while path[-1] in self._frames and self._frames[path[-1]].parent not in path:
            path.append(self._frames[path[-1]].parent)
        return path


class SampledTransforms:
    """A buffer and listener of tf that takes nothing from the future and knows its gaps.

    Args:
        longest_gap: [s] between two transforms.
        max_future: [s] those stamped farther ahead are refused.
        refused: is called with what a transform that is not taken counts as, and why.
    """

    def __init__(
        self, longest_gap: float, max_future: float, refused: Callable[[Outcome, str], None]
    ) -> None:
        self._buffer, self._gaps = tf2_ros.Buffer(), SampleGaps(longest_gap)
        self._max_future, self._refused = max_future, refused
        self._lock = threading.Lock()
        self._subscribers = [
            rospy.Subscriber("/tf", TFMessage, self._take, False, queue_size=100),
            rospy.Subscriber("/tf_static", TFMessage, self._take, True, queue_size=100),
        ]

    def lookup(self, target: str, source: str, stamp: rospy.Time):
        """TransformStamped; TransformException where it is not known, or only by a guess."""
        found = self._buffer.lookup_transform(target, source, stamp)
        with self._lock:
            gap = self._gaps.gap(target, source, stamp.to_sec())
        if gap:
            raise tf2_ros.ExtrapolationException(gap)
        return found

    def clear(self) -> None:
        """Forget all that moves."""
        self._buffer.clear()
        with self._lock:
            self._gaps.clear()

    def _take(self, message: TFMessage, static: bool) -> None:
        now = rospy.Time.now()
        for one in message.transforms:
            parent, child = (n.lstrip("/") for n in (one.header.frame_id, one.child_frame_id))
            ahead = (one.header.stamp - now).to_sec()
            if not is_transform(one.transform):  # tf2 drops it, so it must not fill a gap
                why = f"{parent} -> {child}: must be finite, its quaternion of length 1"
                self._refused(Outcome.BAD_FIELDS, why)
            elif static:
                self._buffer.set_transform_static(one, "default_authority")
            elif ahead > self._max_future:
                self._refused(Outcome.FUTURE, f"{parent} -> {child} {ahead:.3f} s ahead")
            else:
                with self._lock:  # first, so that nobody sees what they do not know of
                    self._gaps.note(parent, child, one.header.stamp.to_sec())
                self._buffer.set_transform(one, "default_authority")
