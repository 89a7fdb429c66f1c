"""Whether a process has work, as the fault campaign asks before its clock goes on."""

import os
import subprocess
import sys
import threading

import pytest

from bench.fault_rest import at_rest, cpu_time

LOOKS = 50


@pytest.fixture
def child():
    """Does what it is told in a line, and says so."""
    code = (
        "import sys\n"
        "for line in sys.stdin:\n"
        "    print('heard', flush=True)\n"
        "    while line == 'work\\n': pass\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", code], **pipes)
    yield process
    process.kill()
    process.communicate()


def tell(child, what):
    child.stdin.write(what + "\n")
    child.stdin.flush()
    child.stdout.readline()


def test_who_waits_is_at_rest_and_who_works_is_not(child):
    tell(child, "wait")
    while not at_rest(child.pid):  # the end of its print may still be under way
        pass
    before = cpu_time(child.pid)
    tell(child, "work")
    assert not any(at_rest(child.pid) for _ in range(LOOKS))
    while cpu_time(child.pid) < before + 0.05:
        pass
    child.kill()
    child.wait()
    assert at_rest(child.pid)
    assert cpu_time(child.pid) == 0.0


def test_of_the_own_process_all_but_who_asks():
    stop = threading.Event()
    worker = threading.Thread(target=lambda: [None for _ in iter(stop.is_set, True)])
    worker.start()
    resting = [at_rest(os.getpid()) for _ in range(LOOKS)]
    stop.set()
    worker.join()
    assert not any(resting)
    while not at_rest(os.getpid()):
        pass
