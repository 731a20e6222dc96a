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

"""One flight with real nodes, recorded: what ``launch_tracking`` and ``uav_tracking fly`` do."""

from __future__ import annotations

import math
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import Progress, TextColumn

from uav_tracking_mpc.control.guidance import compiled_into
from uav_tracking_mpc.launch.supervisor import (
    CONTROLLER,
    SIMULATOR,
    STOP_LIMIT,
    LaunchError,
    NodeProcess,
    Supervisor,
    supervised,
)
from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.nodes.ros.ros_environment import VARIABLE, exported_domain
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.link import LinkParameters

if TYPE_CHECKING:
    from rclpy.experimental.events_executor import EventsExecutor
    from rclpy.node import Node
    from rclpy.task import Future

    from uav_tracking_mpc.nodes.flight_recorder import FlightRecorder
    from uav_tracking_mpc.nodes.flight_recorder import Progress as Standing


REAL_TIME = 1.0  # -, simulated over wall time: the factor of a real clock
START_LIMIT = 120.0  # s of wall time for the first command
DRAIN_TIME = 0.3  # s of wall time without a state or command: no more wait for the recorder
LOOK_PERIOD = 0.2  # s of wall time between looks at where the flight stands
REPORT_PERIOD = 5.0  # s of wall time between lines where there is no terminal
COMMAND = "uav_tracking_mpc.cli.main"  # module of the page and of the simulated autopilot


class FlightInterruptedError(LaunchError):
    """A signal came before anything flew.

    Args:
        number: Number of the signal.
        link: Whether a real autopilot was to be engaged.

    Attributes:
        signal: Number of the signal.
    """

    def __init__(self, number: int, link: bool = False) -> None:
        first = "the autopilot was engaged" if link else "the first command"
        super().__init__(f"interrupted before {first}")
        self.signal = number


class BrokenFlightError(LaunchError):
    """A node died in flight; what was flown until then has been recorded."""


class SimulatedPace:
    """How fast simulated time runs: not above real time while the solver is being compiled.

    The solver that stands in meanwhile takes tens of milliseconds for a plan, which is enough in
    real time and not at ten times that.

    Args:
        configuration: What is flown; its mission says how fast.
        node: With which the simulator is asked.
        console: Where it is said that the simulator refused.

    Attributes:
        speed: Simulated over wall time at the start [-].
    """

    def __init__(self, configuration: Configuration, node: Node, console: Console) -> None:
        from uav_tracking_mpc.nodes.watching import RemoteParameters

        self._wanted, self._console = configuration.mission.speed, console
        self._folder = compiled_into(configuration.controller)
        waits = self._folder is not None and not machine_code.finished(self._folder)
        self._done = not waits or self._wanted <= REAL_TIME
        self.speed = self._wanted if self._done else REAL_TIME
        self._simulator = RemoteParameters(node, SIMULATOR)

    def follow(self) -> None:
        """Ask for the wanted speed once the solver is compiled; returns at once."""
        if self._done or self._folder is None or not machine_code.finished(self._folder):
            return
        if self._simulator.offered:
            self._done = True
            self._simulator.set({"speed": self._wanted}).add_done_callback(self._answered)

    def _answered(self, answer: Future[Any]) -> None:
        response = answer.result()
        if response is not None and not response.result.successful:
            reason = response.result.reason
            words = f"simulated time goes on at {self.speed:g} times real time: {reason}"
            self._console.print(words, markup=False, highlight=False, soft_wrap=True)


def serve_kill(node: Node, supervisor: Supervisor) -> Callable[[], None]:
    """Serve ``nmpc_controller/kill`` of a simulated flight, for trials.

    A flight does not end over that death: the process is missed by nobody and started at once, as
    it was started before, with the parameters of the start.

    Args:
        node: Of the launcher; serves the service.
        supervisor: Of the controller's process.

    Returns:
        Does what was asked for since the last call: a callback does not wait for a process.
    """
    from std_srvs.srv import Trigger

    asked = threading.Event()

    def on_request(request: Any, response: Any) -> Any:
        asked.set()
        response.success = True
        response.message = f"{CONTROLLER} is killed and started again"
        return response

    def follow() -> None:
        if asked.is_set():
            asked.clear()
            supervisor.kill(CONTROLLER)
            supervisor.restart(CONTROLLER)

    node.create_service(Trigger, f"{CONTROLLER}/kill", on_request)
    return follow


def launch(
    configuration: Configuration,
    *,
    domain: int | None = None,
    bag: Path | None = None,
    console: Console | None = None,
    link: bool = False,
) -> int | None:
    """Fly a configuration with real nodes until its duration is over or a signal comes.

    Args:
        configuration: What to fly.
        domain: ROS_DOMAIN_ID; by default the exported one, else one of its own.
        bag: MCAP file to record every topic to, the only one in its folder: ``metadata.yaml`` comes
            beside it.
        console: Where output and progress go, stderr by default.
        link: Fly a real autopilot through the configuration's link, in wall time; the duration
            counts from when it is engaged.

    Returns:
        Number of the signal that ended the flight, None if it was flown to its end.

    Raises:
        BrokenFlightError: A node died in flight.
        DomainValueError: The exported domain is not allowed.
        LaunchError: A node died before that, or nothing flew.
        ModuleNotFoundError: There is no rclpy.
        OSError: The bag could not be written; it is flown to the end all the same.
    """
    console = console or Console(stderr=True)
    exported = domain is None
    domain = exported_domain() if exported else domain
    of_whom = f" (from {VARIABLE})" if exported and domain is not None else ""
    with signals() as received, supervised(console, domain) as supervisor:
        console.print(
            f"domain {supervisor.domain}{of_whom}: watch with "
            f"`uav_tracking monitor --domain-id {supervisor.domain}`",
            highlight=False,
            soft_wrap=True,
        )
        return _fly(configuration, supervisor, bag, received, console, link)


def _fly(
    configuration: Configuration,
    supervisor: Supervisor,
    bag_path: Path | None,
    received: list[int],
    console: Console,
    link: bool,
) -> int | None:
    from rclpy.experimental.events_executor import EventsExecutor

    from uav_tracking_mpc.nodes.flight_recorder import FlightBag, FlightRecorder

    with ExitStack() as stack:
        bag = None
        if bag_path is not None:
            bag = FlightBag(bag_path, alone=True)
            stack.callback(bag.discard)  # nothing, once it is closed
        recorder = FlightRecorder(bag, link)
        stack.callback(recorder.destroy_node)
        executor = EventsExecutor()
        stack.callback(executor.shutdown)
        executor.add_node(recorder)
        follow: list[Callable[[], None]] = []
        limit, died = START_LIMIT, None
        try:
            if not link:  # nobody kills what commands a real aircraft
                pace = SimulatedPace(configuration, recorder, console)
                follow = [pace.follow, serve_kill(recorder, supervisor)]
                supervisor.start_flight(configuration, pace.speed)
            else:
                supervisor.start_link_flight(configuration)
                if not configuration.link.engage:
                    console.print(
                        _how_to_engage(configuration.link, supervisor.domain), soft_wrap=True
                    )
                    limit = math.inf
            _watch(configuration, supervisor, recorder, executor, received, console, limit, follow)
        except LaunchError as error:
            died = error
        finally:
            supervisor.end(lambda: _drain(supervisor, recorder, executor))
        if recorder.progress().time is not None:
            if recorder.failure is not None:
                raise recorder.failure
            if bag is not None:
                bag.close()
            if died is not None:
                raise BrokenFlightError(str(died)) from died
        elif died is not None:
            raise died
        elif received:
            raise FlightInterruptedError(received[0], link)
    return received[0] if received else None


def _watch(
    configuration: Configuration,
    supervisor: Supervisor,
    recorder: FlightRecorder,
    executor: EventsExecutor,
    received: list[int],
    console: Console,
    limit: float,
    follow: Sequence[Callable[[], None]],
) -> None:
    """Spin the recorder and show progress until the mission ends, a signal comes or a node dies."""
    duration = configuration.mission.duration
    begin = shown = looked = time.monotonic()
    columns = TextColumn("{task.description}"), TextColumn("{task.percentage:3.0f}%")
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("starting", total=duration)
        while not received:
            executor.spin_once(timeout_sec=0.05)
            now = time.monotonic()
            if now - looked < LOOK_PERIOD:  # decoding costs what the recorder needs to keep up
                continue
            looked = now
            supervisor.check()
            for act in follow:
                act()
            progress = recorder.progress()
            if progress.time is None:
                if now - begin > limit:
                    what = "no command" if progress.engaged is None else "not engaged"
                    raise LaunchError(f"{what} within {limit:g} s")
                continue
            if progress.time >= duration:
                return
            if console.is_terminal or now - shown > REPORT_PERIOD:
                shown = now
                line = progress_line(progress)
                bar.update(task, completed=progress.time, description=line)
                if not console.is_terminal:
                    console.print(line, highlight=False, soft_wrap=True)


def progress_line(progress: Standing) -> str:
    """Where a flight stands; with a percentage behind it no wider than 80 characters.

    Args:
        progress: With a time.
    """
    return (
        f"t {progress.time:4.0f} s  range {progress.range:6.1f} m  "
        f"altitude {progress.altitude:5.1f} m  speed {progress.speed:4.1f} m/s  "
        f"solve {progress.solve_time * 1e6:5.0f} us"
    )


def _how_to_engage(parameters: LinkParameters, domain: int) -> str:
    """What the pilot can do to hand over command, in words."""
    words = (
        f"nothing is commanded until somebody engages: `uav_tracking engage --domain-id {domain}`"
    )
    if parameters.engage_on_mode:
        words += ", or switch the autopilot to its mode of external commands"
    return words


def _drain(supervisor: Supervisor, recorder: FlightRecorder, executor: EventsExecutor) -> None:
    """Record what still waits, and what the nodes publish last: their diagnostics."""
    deadline = time.monotonic() + STOP_LIMIT
    while time.monotonic() < deadline and len(supervisor.dead()) < len(supervisor.processes):
        executor.spin_once(timeout_sec=0.05)
    heard, silent = -1, 0.0
    deadline = time.monotonic() + STOP_LIMIT  # others may go on publishing in this domain
    while time.monotonic() < deadline and (
        recorder.heard > heard or time.monotonic() - silent < DRAIN_TIME
    ):
        if recorder.heard > heard:
            heard, silent = recorder.heard, time.monotonic()
        executor.spin_once(timeout_sec=0.05)


@contextmanager
def signals() -> Iterator[list[int]]:
    """SIGINT and SIGTERM as a list that fills, instead of exceptions."""
    received: list[int] = []
    previous = {
        number: signal.signal(number, lambda number, _: received.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield received
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


@contextmanager
def page_process(
    domain: int, arguments: Sequence[str], console: Console
) -> Iterator[Callable[[], None]]:
    """Serve a page by a process while the context lasts; its death ends no flight.

    Args:
        domain: ROS domain that is shown.
        arguments: More of ``uav_tracking view``.
        console: Where its output goes, its address among it.

    Yields:
        Waits until Ctrl-C, or until the page has ended.
    """
    words = ["view", "--domain-id", str(domain), *arguments]
    process = NodeProcess("page", COMMAND, words, console)

    def stay() -> None:
        with signals() as received:  # before a word invites Ctrl-C
            if process.exit_code is None:
                console.print("the page shows the end of the flight until Ctrl-C", highlight=False)
            while process.exit_code is None and not received:
                time.sleep(LOOK_PERIOD)

    try:
        yield stay
    finally:
        process.stop(signal.SIGTERM)


@contextmanager
def autopilot_process(configuration: Configuration, console: Console) -> Iterator[str]:
    """Fly a simulated autopilot of the link's kind while the context lasts.

    Args:
        configuration: Its section ``uav_simulator`` is what flies, ``autopilot_link`` says how the
            autopilot behaves.
        console: Where its output goes.

    Yields:
        The connection at which the link finds it.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{configuration.name}.yaml"
        file.write_text(configuration.yaml(), encoding="utf-8")
        arguments = ["autopilot", "--dialect", configuration.link.link]
        arguments += ["--config", str(file), "--connection", f"udpout:{place}"]
        if configuration.link.origin:
            # One word: South of the equator two would look like an option.
            arguments.append("--origin=" + ",".join(map(str, configuration.link.origin)))
        if configuration.link.signing_key:
            arguments += ["--signing-key", configuration.link.signing_key]
        if configuration.link.target_system:
            arguments += ["--target-system", str(configuration.link.target_system)]
        process = NodeProcess("autopilot", COMMAND, arguments, console)
        try:
            yield f"udpin:{place}"
        finally:
            process.stop(signal.SIGTERM)
