"""The nodes as processes, started by plain Python: ``launch_tracking`` and ``uav_tracking fly``.

Discovery stays on this machine and each launch has a domain of its own, so that two do not mix.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from uav_tracking_mpc.launch.domain import DomainError, domain_number, own_domain
from uav_tracking_mpc.launch.node_process import STOP_LIMIT, NodeProcess
from uav_tracking_mpc.launch.shared_memory import SharedMemoryFiles
from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    load_configuration,
    scenario_names,
)
from uav_tracking_mpc.settings.mission import MissionParameters
from uav_tracking_mpc.simulation.plants import SimulationError

NODES = ("uav_simulator", "target_publisher", "nmpc_controller")
START_LIMIT = 60.0  # s of wall time for the first command
DRAIN_TIME = 0.3  # s of wall time for the nodes' last messages
NOTE_PERIOD = 0.5  # s of wall time between looks at the nodes' shared-memory files
LOOK_PERIOD = 0.2  # s of wall time between looks at where the flight stands
REPORT_PERIOD = 5.0  # s of wall time between lines where there is no terminal


class LaunchError(RuntimeError):
    """The flight could not be flown; the message says why."""


class FlightInterruptedError(LaunchError):
    """A signal came before anything flew.

    Attributes:
        signal: Its number.
    """

    def __init__(self, number: int) -> None:
        super().__init__("interrupted before the first command")
        self.signal = number


def launch(
    configuration: Configuration,
    *,
    domain: int | None = None,
    bag: Path | None = None,
    console: Console | None = None,
) -> int | None:
    """Fly a configuration with real nodes until its duration is over or a signal comes.

    Args:
        configuration: What to fly.
        domain: ROS_DOMAIN_ID; by default one of its own.
        bag: MCAP file to record every topic to.
        console: Where output and progress go, stderr by default.

    Returns:
        Number of the signal that ended the flight, None if it was flown to its end.

    Raises:
        LaunchError: A node died, or nothing flew.
        ModuleNotFoundError: There is no rclpy.
    """
    console = console or Console(stderr=True)
    with own_domain(domain) as claimed, _signals() as received:
        os.environ.update(
            ROS_DOMAIN_ID=str(claimed),
            ROS_AUTOMATIC_DISCOVERY_RANGE=os.environ.get(
                "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
            ),
            RCUTILS_COLORIZED_OUTPUT="0",
        )
        # rclpy reads the environment when it is loaded.
        import rclpy
        from rclpy.signals import SignalHandlerOptions

        console.print(
            f"domain {claimed}: watch with `uav_tracking monitor --domain-id {claimed}`",
            highlight=False,
        )
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        files = SharedMemoryFiles()
        try:
            return _fly(configuration, bag, files, received, console)
        finally:
            rclpy.try_shutdown()
            files.remove_orphans()


def _fly(
    configuration: Configuration,
    bag_path: Path | None,
    files: SharedMemoryFiles,
    received: list[int],
    console: Console,
) -> int | None:
    from rclpy.experimental.events_executor import EventsExecutor

    from uav_tracking_mpc.nodes.flight_bag import FlightBag
    from uav_tracking_mpc.nodes.flight_recorder import FlightRecorder

    bag = None if bag_path is None else FlightBag(bag_path)
    processes: list[NodeProcess] = []
    recorder = FlightRecorder(bag)
    executor = EventsExecutor()
    executor.add_node(recorder)
    try:
        with tempfile.TemporaryDirectory() as folder:
            parameters = Path(folder) / "parameters.yaml"
            parameters.write_text(configuration.yaml(), encoding="utf-8")
            try:
                for name in NODES:
                    arguments = node_arguments(name, parameters, configuration)
                    processes.append(NodeProcess(name, arguments, console))
                _watch(configuration, recorder, executor, processes, files, received, console)
            finally:
                files.note(process.identity for process in processes)
                # SIGTERM, whichever came: a node that is still loading ends on it without a word.
                for process in processes:
                    process.send_signal(signal.SIGTERM)
                _drain(executor, processes)  # their last diagnostics
                for process in processes:
                    process.stop(signal.SIGTERM)
        if received and recorder.progress().time is None:
            raise FlightInterruptedError(received[0])
    except BaseException:
        if bag is not None:
            bag.discard()
        raise
    finally:
        executor.shutdown()
        recorder.destroy_node()
    if bag is not None:
        bag.close()
    return received[0] if received else None


def node_arguments(name: str, parameters: Path, configuration: Configuration) -> list[str]:
    """Command line of a node that flies a mission before one more listener to the state."""
    arguments = ["--ros-args", "--params-file", str(parameters)]
    if name == "uav_simulator":
        speed = configuration.mission.speed
        # Time starts when controller and recorder listen, the vehicle when it is commanded.
        extra = [
            "publish_clock:=true",
            "wait_for_subscribers:=2",
            "start_on_command:=true",
            f"speed:={speed!r}",
        ]
    else:
        extra = ["use_sim_time:=true"]
    for assignment in extra:
        arguments += ["-p", assignment]
    return arguments


def _watch(
    configuration: Configuration,
    recorder: object,
    executor: object,
    processes: list[NodeProcess],
    files: SharedMemoryFiles,
    received: list[int],
    console: Console,
) -> None:
    """Spin the recorder and show progress until the mission ends, a signal comes or a node dies."""
    duration = configuration.mission.duration
    begin = shown = looked = time.monotonic()
    noted = 0.0
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f}%"))
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("starting", total=duration)
        while not received:
            executor.spin_once(timeout_sec=0.05)  # type: ignore[attr-defined]
            for process in processes:
                if process.exit_code is not None:
                    raise LaunchError(f"{process.name} died with exit code {process.exit_code}")
            now = time.monotonic()
            if now - noted > NOTE_PERIOD:
                noted = now
                files.note([os.getpid(), *(process.identity for process in processes)])
            if now - looked < LOOK_PERIOD:  # decoding costs what the recorder needs to keep up
                continue
            looked = now
            progress = recorder.progress()  # type: ignore[attr-defined]
            if progress.time is None:
                if now - begin > START_LIMIT:
                    raise LaunchError(f"no command within {START_LIMIT:g} s")
                continue
            if progress.time >= duration:
                return
            if console.is_terminal or now - shown > REPORT_PERIOD:
                shown = now
                line = (
                    f"t {progress.time:6.1f} s   range {progress.range:7.2f} m   "
                    f"altitude {progress.altitude:6.2f} m   speed {progress.speed:5.2f} m/s   "
                    f"solve {progress.solve_time * 1e6:6.0f} us"
                )
                bar.update(task, completed=progress.time, description=line)
                if not console.is_terminal:
                    console.print(line, highlight=False, soft_wrap=True)


def _drain(executor: object, processes: list[NodeProcess]) -> None:
    deadline = time.monotonic() + STOP_LIMIT
    while time.monotonic() < deadline and any(p.exit_code is None for p in processes):
        executor.spin_once(timeout_sec=0.05)  # type: ignore[attr-defined]
    deadline = time.monotonic() + DRAIN_TIME
    while time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.05)  # type: ignore[attr-defined]


@contextmanager
def _signals() -> Iterator[list[int]]:
    """SIGINT and SIGTERM as a list that fills, instead of exceptions."""
    received: list[int] = []

    def remember(number: int, frame: FrameType | None) -> None:
        received.append(number)

    previous = {
        number: signal.signal(number, remember) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield received
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


@dataclass
class Ending:
    """How a command ended.

    Attributes:
        code: Exit code: 0 done, 1 failed, 2 asked for what is not allowed, 128 + n by signal n.
    """

    code: int = 0


@contextmanager
def explained(program: str) -> Iterator[Ending]:
    """Turn what a command may expect to go wrong into one line and an exit code."""
    ending = Ending()
    try:
        yield ending
    except FlightInterruptedError as error:
        ending.code, message = 128 + error.signal, str(error)
    except KeyboardInterrupt:
        ending.code, message = 128 + signal.SIGINT, "interrupted"
    except ParameterError as error:
        ending.code, message = 2, str(error)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith("uav_tracking_mpc"):
            raise
        ending.code = 1
        message = (
            f"{error.name} is not installed; flying needs ROS 2 Jazzy: source its setup file, or "
            "`pip install 'uav_tracking_mpc[ros]'`"
        )
    except (LaunchError, DomainError, SimulationError, OSError) as error:
        ending.code, message = 1, str(error)
    else:
        return
    print(f"{program}: {message}", file=sys.stderr)


def add_configuration_arguments(parser: argparse.ArgumentParser, default: str = "paper") -> None:
    """Options that choose a configuration."""
    parser.add_argument(
        "--config",
        default=default,
        metavar="NAME|FILE",
        help=f"configuration (default: {default})",
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="SECTION.PARAMETER=VALUE",
        help="override a parameter, e.g. nmpc_controller.model=paper; may be repeated",
    )


def add_mission_arguments(parser: argparse.ArgumentParser) -> None:
    """Options that every command flying a configuration has."""
    add_configuration_arguments(parser)
    parser.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        help=f"wind, target and measurements: {', '.join(scenario_names())}",
    )
    for specification in specifications(MissionParameters):
        if isinstance(specification.default, float):
            parser.add_argument(
                f"--{specification.name}",
                type=float,
                metavar="NUMBER",
                help=f"{specification.description} ({specification.allowed})",
            )


def mission_configuration(arguments: argparse.Namespace) -> Configuration:
    """Configuration asked for on a command line.

    Raises:
        ParameterError: It does not exist or is not allowed.
    """
    overrides = list(arguments.overrides)
    for name in ("duration", "speed"):
        value = getattr(arguments, name)
        if value is not None:
            overrides.append(f"mission.{name}={value!r}")
    return load_configuration(arguments.config, overrides, arguments.scenario)


def add_launch_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of commands that start nodes."""
    parser.add_argument(
        "--domain-id",
        type=domain_number,
        metavar="N",
        help="ROS domain to fly in (default: one that no other launch uses)",
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the executable ``launch_tracking``."""
    parser = argparse.ArgumentParser(
        prog="launch_tracking",
        description="Start simulator, target and controller as processes and watch over them. "
        "Ctrl-C ends them all.",
    )
    add_mission_arguments(parser)
    add_launch_arguments(parser)
    parsed = parser.parse_args(arguments)
    # A launcher runs until somebody ends it: a signal is no failure, as for a node.
    with explained("launch_tracking") as ending, suppress(FlightInterruptedError):
        launch(mission_configuration(parsed), domain=parsed.domain_id)
    return ending.code


if __name__ == "__main__":
    sys.exit(main())
