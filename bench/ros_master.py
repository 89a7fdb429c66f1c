"""A ROS master of our own, and programs on it."""

from __future__ import annotations

import os
import socket
import subprocess
import time
import xmlrpc.client
from contextlib import contextmanager
from typing import Iterator

import roslib.packages


@contextmanager
def private_master() -> Iterator[dict]:
    """The environment of those who shall find it."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    env = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost")
    with running(["rosmaster", "--core", "-p", str(port)], env):
        _wait_for_master(env["ROS_MASTER_URI"])
        yield env


@contextmanager
def running(command: list[str], env: dict) -> Iterator[None]:
    """A program that is ended with the block."""
    process = subprocess.Popen(command, env=env, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(timeout=10)


def program(name: str, package: str = "safe_passage") -> str:
    """Path of an executable of a package."""
    found = roslib.packages.find_node(package, name)
    if not found:
        raise FileNotFoundError(f"{name} is not built")
    return found[0]


def _wait_for_master(uri: str) -> None:
    for _ in range(100):
        try:
            xmlrpc.client.ServerProxy(uri).getPid("/bench")
            return
        except OSError:
            time.sleep(0.1)
    raise TimeoutError("rosmaster did not start")
