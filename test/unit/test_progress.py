"""Progress: a bar on terminals, a line a quarter elsewhere."""

import io

from safe_passage.core.progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_line_a_quarter():
    stream = io.StringIO()
    progress = Progress("views", 40, stream)
    for done in range(1, 41):
        progress.show(done)
    lines = stream.getvalue().splitlines()
    assert [line.split(",")[0].strip() for line in lines] == [
        f"views: {done} of 40" for done in (10, 20, 30, 40)
    ]


def test_quarters_may_be_jumped_over():
    stream = io.StringIO()
    progress = Progress("runs", 2, stream)
    progress.show(1)
    progress.show(2)
    assert len(stream.getvalue().splitlines()) == 2


def test_a_bar_on_a_terminal():
    stream = Terminal()
    progress = Progress("runs", 4, stream)
    progress.show(2)
    progress.show(4)
    shown = stream.getvalue()
    assert "#" * 20 + "." * 20 in shown
    assert shown.count("\n") == 1 and shown.endswith("\n")
