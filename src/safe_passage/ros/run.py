"""Starts a node's main; an error of ours becomes one clear line instead of a trace."""

from __future__ import annotations

import sys
from typing import Callable

import rospy

from safe_passage.core.errors import SafePassageError


def run(main: Callable[[], None]) -> None:
    """Call `main`; exit with 1 after logging a SafePassageError."""
    try:
        main()
    except rospy.ROSInterruptException:
        pass
    except SafePassageError as error:
        rospy.logfatal(str(error))
        sys.exit(1)
