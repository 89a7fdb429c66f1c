"""How far a long run is."""

from __future__ import annotations

import sys
import time
from typing import TextIO

WIDTH = 40  # characters of the bar


class Progress:
    """A bar that fills up on a terminal, a line a quarter elsewhere.

    Args:
        what: is being done.
        total: how many pieces of it there are.
        stream: where to show it; standard error without one.
    """

    def __init__(self, what: str, total: int, stream: TextIO | None = None) -> None:
        self._what, self._total = what, max(total, 1)
        self._stream = stream or sys.stderr
        self._start, self._quarter = time.monotonic(), 0
        self.show(0)

    def show(self, done: int) -> None:
        """Say that `done` of the pieces are done."""
        share = done / self._total
        seconds = time.monotonic() - self._start
        if self._stream.isatty():
            bar = "#" * round(WIDTH * share)
            end = "\n" if share >= 1.0 else ""
            line = f"\r  {self._what} [{bar:.<{WIDTH}}] {done}/{self._total} {seconds:4.0f} s"
            print(line, end=end, file=self._stream, flush=True)
        elif int(4 * share) > self._quarter:
            self._quarter = int(4 * share)
            line = f"  {self._what}: {done} of {self._total}, {seconds:.0f} s"
            print(line, file=self._stream, flush=True)
