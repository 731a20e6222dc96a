# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The one supervisor of node processes: starts, watches, freezes, kills, restarts and ends them.

No process outlives its launcher, whatever ended that.
Discovery stays on this machine and each launch has a domain of its own, so that two do not mix.
"""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console

from uav_tracking_mpc.nodes.ros.ros_environment import (
    VARIABLE,
    ensure_log_folder,
    stay_on_this_machine,
)
from uav_tracking_mpc.settings.configuration import Configuration

FIRST_DOMAIN, LAST_DOMAIN = 1, 101  # what Linux's ephemeral ports leave free
STOP_LIMIT = 5.0  # s of wall time for a node to end after a signal
NODES = SIMULATOR, TARGET, CONTROLLER = "uav_simulator", "target_publisher", "nmpc_controller"
LINK = "autopilot_link"  # in the simulator's place


class LaunchError(RuntimeError):
    """The flight could not be flown; the message says why."""


@contextmanager
def own_domain(domain: int | None) -> Iterator[int]:
    """A ROS domain that no other launch on this machine uses.

    A TCP port stands for the domain while it is in use; it carries no traffic.

    Args:
        domain: Take this one instead, whoever else is on it.

    Yields:
        Number of the domain.

    Raises:
        LaunchError: All domains are in use.
    """
    if domain is not None:
        yield domain
        return
    count = LAST_DOMAIN - FIRST_DOMAIN + 1
    for offset in range(count):
        candidate = FIRST_DOMAIN + (os.getpid() + offset) % count
        with socket.socket() as claim:
            try:
                claim.bind(("127.0.0.1", 7400 + 250 * candidate))  # where DDS puts its domains
            except OSError:
                continue
            yield candidate
            return
    raise LaunchError(f"all ROS domains from {FIRST_DOMAIN} to {LAST_DOMAIN} are in use")


class NodeProcess:
    """One node as a process; its output is printed line by line behind its name.

    Args:
        name: By which its output is marked.
        module: Full name of its Python module.
        arguments: Its command line.
        console: Where its output goes.

    Attributes:
        name: By which its output is marked.
        started: When it was started, by the steady clock [s].
    """

    def __init__(self, name: str, module: str, arguments: Sequence[str], console: Console) -> None:
        self.name = name
        self.started = time.monotonic()
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            # A session of its own: Ctrl-C reaches the launcher alone, which passes it on.
            start_new_session=True,
            preexec_fn=_end_with_parent,
        )
        self._reader = threading.Thread(target=self._print, args=(console,), daemon=True)
        self._reader.start()

    def _print(self, console: Console) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            # The loggers of ROS tell the name again.
            words = line.rstrip().replace(f" [{self.name}]:", ":", 1)
            console.print(f"[{self.name}] {words}", markup=False, highlight=False, soft_wrap=True)

    @property
    def identity(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs."""
        return self._process.poll()

    def send_signal(self, number: int) -> None:
        """Send a signal, if the process still runs.

        Args:
            number: Of the signal.
        """
        if self.exit_code is None:
            self._process.send_signal(number)

    def stop(self, number: int) -> None:
        """End the process: by a signal, and by force if that takes longer than STOP_LIMIT.

        Args:
            number: Of the signal.
        """
        self.send_signal(number)
        try:
            self._process.wait(STOP_LIMIT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(STOP_LIMIT)


def _end_with_parent() -> None:
    """In the child: ask Linux for SIGTERM when the launcher dies, whatever ended it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


class Supervisor:
    """Node processes by name.

    Args:
        folder: Existing folder for the nodes' parameter file.
        console: Where the nodes' output goes.
        domain: ROS domain that the nodes fly in.

    Attributes:
        domain: ROS domain that the nodes fly in.
        processes: Processes that were started and not killed, by name.
    """

    def __init__(self, folder: Path, console: Console, domain: int) -> None:
        self.domain = domain
        self.processes: dict[str, NodeProcess] = {}
        self._parameters = folder / "parameters.yaml"
        self._console = console
        self._commands: dict[str, tuple[str, tuple[str, ...]]] = {}

    def start(self, name: str, module: str, arguments: Sequence[str] = ()) -> None:
        """Start a node.

        Args:
            name: By which the supervisor and the output call it.
            module: Full name of its Python module.
            arguments: Its command line.
        """
        self._commands[name] = module, tuple(arguments)
        self.restart(name)

    def start_flight(
        self,
        configuration: Configuration,
        speed: float,
        remaps: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """Start the three nodes of a simulated flight.

        Args:
            configuration: What they fly.
            speed: Simulated over wall time [-].
            remaps: Remapping rules of each node by its name, such as ``{"uav_simulator":
                ["uav/odometry:=raw/uav/odometry"]}``.
        """
        self._parameters.write_text(configuration.yaml(), encoding="utf-8")
        # Time starts when the controller and one more listener hear the state, the vehicle when it
        # is commanded.
        driven = ["publish_clock:=true", "wait_for_subscribers:=2", "start_on_command:=true"]
        for name in NODES:
            follows = ["use_sim_time:=true"]
            assignments = [*driven, f"speed:={speed!r}"] if name == SIMULATOR else follows
            self._start_node(name, assignments, (remaps or {}).get(name, ()))

    def start_link_flight(self, configuration: Configuration) -> None:
        """Start the nodes of a flight with a real autopilot, in wall time.

        Args:
            configuration: What they fly; its link may bring the target, too.
        """
        self._parameters.write_text(configuration.yaml(), encoding="utf-8")
        target = () if configuration.link.target_system else (TARGET,)
        for name in (LINK, *target, CONTROLLER):
            self._start_node(name)

    def _start_node(
        self, name: str, assignments: Sequence[str] = (), rules: Sequence[str] = ()
    ) -> None:
        """Start a node of the package with the parameter file, further parameters and remaps."""
        flags = [word for rule in rules for word in ("-r", rule)]
        flags += [word for assignment in assignments for word in ("-p", assignment)]
        arguments = ["--ros-args", "--params-file", str(self._parameters), *flags]
        self.start(name, f"uav_tracking_mpc.nodes.{name}", arguments)

    def restart(self, name: str) -> None:
        """Start a node that has ended or was killed as it was started before.

        Args:
            name: Of the node.
        """
        module, arguments = self._commands[name]
        self.processes[name] = NodeProcess(name, module, arguments, self._console)

    def kill(self, name: str) -> None:
        """End a node by SIGKILL; :meth:`dead` does not report it.

        Args:
            name: Of the node.
        """
        self.processes.pop(name).stop(signal.SIGKILL)

    def freeze(self, name: str) -> None:
        """Stop a node where it stands (SIGSTOP).

        Args:
            name: Of the node.
        """
        self.processes[name].send_signal(signal.SIGSTOP)

    def thaw(self, name: str) -> None:
        """Let a frozen node go on (SIGCONT).

        Args:
            name: Of the node.
        """
        self.processes[name].send_signal(signal.SIGCONT)

    def dead(self) -> dict[str, int]:
        """Exit codes of the processes that have ended though nobody killed them, by name."""
        codes = {name: process.exit_code for name, process in self.processes.items()}
        return {name: code for name, code in codes.items() if code is not None}

    def check(self) -> None:
        """Make sure that every process runs.

        Raises:
            LaunchError: A process has ended.
        """
        dead = self.dead()
        if dead:
            words = "; ".join(f"{name} died with exit code {code}" for name, code in dead.items())
            raise LaunchError(words)

    def end(self, meanwhile: Callable[[], None] = lambda: None) -> None:
        """End every process.

        Args:
            meanwhile: Called once when all of them were told to end, before those that do not are
                killed.
        """
        for process in self.processes.values():
            # SIGTERM, not SIGINT: a node that is still loading ends on it without a traceback.
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGCONT)
        meanwhile()
        while self.processes:
            self.processes.popitem()[1].stop(signal.SIGTERM)


@contextmanager
def supervised(console: Console, domain: int | None = None) -> Iterator[Supervisor]:
    """ROS in this process and a supervisor; everything is ended at the end.

    Args:
        console: Where the nodes' output goes.
        domain: ROS_DOMAIN_ID; None takes one that no other launch uses.

    Yields:
        The supervisor, without processes.

    Raises:
        LaunchError: All domains are in use.
        ModuleNotFoundError: There is no rclpy.
    """
    with own_domain(domain) as claimed, tempfile.TemporaryDirectory() as folder:
        before = os.environ.get(VARIABLE)
        os.environ.update(ROS_DOMAIN_ID=str(claimed), RCUTILS_COLORIZED_OUTPUT="0")
        try:
            stay_on_this_machine()
            if changed := ensure_log_folder():
                console.print(changed, highlight=False, soft_wrap=True)
            import rclpy
            from rclpy.signals import SignalHandlerOptions

            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
            supervisor = Supervisor(Path(folder), console, claimed)
            try:
                yield supervisor
            finally:
                supervisor.end()
                rclpy.try_shutdown()
        finally:
            # A later launch of this process is to choose anew.
            if before is None:
                os.environ.pop(VARIABLE, None)
            else:
                os.environ[VARIABLE] = before
