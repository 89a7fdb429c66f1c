"""What the goals of an action are answered, whichever action it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

from actionlib_msgs.msg import GoalStatus

from bench.fault_subject import Check, Seen, of


@dataclass(frozen=True)
class Answers:
    """Of one action."""

    topic: str  # of its results
    of_result: Callable[[Any], Any]  # what of a result says how it went
    reason: str  # its field with the reason of a refusal
    why: str  # its field with the same in a sentence

    def seen(self, seen: Seen) -> list[Any]:
        """Without those to goals that never began, since others came: these are actionlib's own."""
        answers = of(self.topic, seen)
        return [self.of_result(a.result) for a in answers if a.status.status != GoalStatus.RECALLED]

    def refused(self, *reasons: Any) -> Check:
        """Every goal is refused for one of these reasons."""

        def check(seen: Seen) -> str:
            answers = self.seen(seen)
            others = [one for one in answers if getattr(one, self.reason) not in reasons]
            if not answers:
                return "no answer"
            if not others:
                return ""
            return f"{getattr(others[0], self.reason)}: {getattr(others[0], self.why)}"

        return check

    def none(self, seen: Seen) -> str:
        """Nobody has asked."""
        answers = self.seen(seen)
        return f"{len(answers)} answers" if answers else ""
