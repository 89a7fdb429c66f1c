"""Two computers in one: network namespaces with an address each, joined by a cable of their own.

Processes of the second one live in its namespace, with a clock that can be set (skewed_clock.cpp:
the kernel has no namespaces of the wall clock). All of it goes when the last of its holders does,
also when the test is killed: nothing is mounted, no name is left.
"""

import ctypes
import os
import select
import struct
import subprocess
import sys
from pathlib import Path

import roslaunch
from roslaunch.remoteprocess import SSHChildROSLaunchProcess

HERE, THERE = "10.77.0.1", "10.77.0.2"  # known to nobody but the two
CLONE_NEWNET = 0x40000000
SOURCE = Path(__file__).with_name("skewed_clock.cpp")


class NoNamespacesError(Exception):
    """This user, or this kernel, cannot make network namespaces; says why."""


class Host:
    """One of them: a network without a way out.

    Args:
        command: that starts in it what holds it: it ends when our pipe closes.
    """

    def __init__(self, *command):
        pipe = subprocess.PIPE
        words = [*command, "sh", "-c", "echo; cat"]
        self._holder = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
        if not self._holder.stdout.readline():
            raise NoNamespacesError(self._holder.communicate()[1].strip())
        children = Path(f"/proc/{self._holder.pid}/task/{self._holder.pid}/children").read_text()
        self.pid = int(children.split()[0])

    def ip(self, *words):
        """Call ip with its network, and with our process ids."""
        command = ["nsenter", "--target", str(self.pid), "--net", "ip", *words]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"ip {' '.join(words)}: {done.stderr.strip()}")

    def enter(self):
        """This process's next threads and sockets are there, too."""
        with open(f"/proc/{self.pid}/ns/net") as network:
            if ctypes.CDLL(None, use_errno=True).setns(network.fileno(), CLONE_NEWNET):
                raise OSError(ctypes.get_errno(), "setns")

    def end(self):
        """All of its processes, and its network."""
        self._holder.stdin.close()
        self._holder.wait(10.0)
        for pipe in (self._holder.stdout, self._holder.stderr):
            pipe.close()


class TwoHosts:
    """Both, joined. This process moves into the first one, for good."""

    def __init__(self, folder):
        # One space of processes for both: whoever is left in it dies with its first one.
        self.here = Host("unshare", "--net", "--pid", "--fork", "--kill-child")
        self._inside = ["nsenter", "--target", str(self.here.pid), "--pid"]
        self.there = Host(*self._inside, "unshare", "--net")
        self._folder, self._clock = Path(folder), Path(folder) / "clock"
        join = ["link", "add", "to_there", "type", "veth", "peer", "name", "to_here"]
        self.here.ip(*join, "netns", str(self.there.pid))
        for host, name, address in ((self.here, "to_there", HERE), (self.there, "to_here", THERE)):
            host.ip("address", "add", f"{address}/24", "dev", name)
            for device in ("lo", name):
                host.ip("link", "set", device, "up")
        self.here.enter()
        os.environ.update(ROS_IP=HERE, ROS_MASTER_URI=f"http://{HERE}:11311")
        os.environ.pop("ROS_HOSTNAME", None)
        self._clock.write_bytes(struct.pack("d", 0.0))
        self.env_loader = self._write_env_loader()

    def set_clock(self, ahead):
        """Put the second host's clock that far ahead of the first one's [s]; it steps at once."""
        with self._clock.open("r+b") as file:  # in place: all of its processes have it mapped
            file.write(struct.pack("d", ahead))

    def launch(self, file, *arguments):
        """roslaunch on the first host, which starts the second one's part there."""
        program = ["python3", __file__, str(self.there.pid), str(file), *arguments]
        return subprocess.Popen([*self._inside, "--net", *program])

    def end(self):
        """Both, with all that runs there."""
        self.there.end()
        self.here.end()

    def _write_env_loader(self):
        """What <machine env-loader> asks for: a script that sets the environment there."""
        library, path = self._folder / "skewed_clock.so", self._folder / "env.sh"
        options = ["-std=c++17", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror"]
        subprocess.run(["c++", *options, str(SOURCE), "-o", str(library), "-ldl"], check=True)
        path.write_text(f"""#!/bin/sh
export ROS_IP={THERE} LD_PRELOAD={library} SKEWED_CLOCK={self._clock}
exec "$@"
""")
        path.chmod(0o755)
        return path


class Pipe:
    """One of a process's outputs, as paramiko has it: roslaunch reads it so."""

    def __init__(self, stream):
        self._stream, self.channel = stream, self

    def settimeout(self, seconds):
        """Reading never waits here."""

    def read(self, most):
        """What is there; empty at the end, TimeoutError where nothing has come."""
        if not select.select([self._stream], [], [], 0)[0]:
            raise TimeoutError
        return os.read(self._stream.fileno(), most)

    def close(self):
        """No more of it."""
        self._stream.close()


class Ended:
    """What stands for the connection: it ends with its process."""

    def __init__(self, process):
        self._process = process

    def close(self):
        """Wait for the process, as nobody reads it any more."""
        self._process.wait(20.0)


def instead_of_ssh(pid):
    """roslaunch's way to the host of that process: there is no ssh server.

    All else is roslaunch's own: its child there, the env-loader, their talk over the addresses.
    """

    def execute(process, command, address, port, username=None, password=None):
        if address != THERE:
            return None, f"no such host: {address}"
        words = ["nsenter", "--target", pid, "--net", "env", f"ROS_MASTER_URI={process.master_uri}"]
        pipe = subprocess.PIPE
        child = subprocess.Popen(
            [*words, *command.split()], stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0
        )
        return (Ended(child), child.stdin, Pipe(child.stdout), Pipe(child.stderr)), "executed"

    return execute


if __name__ == "__main__":  # PID_THERE FILE ARGUMENT...: roslaunch, with that way to the other host
    SSHChildROSLaunchProcess._ssh_exec = instead_of_ssh(sys.argv[1])
    roslaunch.main(["roslaunch", *sys.argv[2:]])
