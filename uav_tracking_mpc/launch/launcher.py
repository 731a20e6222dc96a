"""The executable ``launch_tracking``, and what the commands that fly share on the command line."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from uav_tracking_mpc.launch.domain import DomainError, domain_number
from uav_tracking_mpc.launch.flight import FlightInterruptedError, launch
from uav_tracking_mpc.launch.supervisor import LaunchError
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    load_configuration,
    scenario_names,
)
from uav_tracking_mpc.settings.mission import MissionParameters
from uav_tracking_mpc.simulation.plants import SimulationError


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
    except (ParameterError, ExtensionError) as error:
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
