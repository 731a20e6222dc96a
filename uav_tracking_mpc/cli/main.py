"""The ``uav_tracking`` command."""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from uav_tracking_mpc import __version__
from uav_tracking_mpc.formulation.paper_terminal import stability_problem
from uav_tracking_mpc.launch.domain import domain_number
from uav_tracking_mpc.launch.flight import launch
from uav_tracking_mpc.launch.launcher import (
    add_configuration_arguments,
    add_launch_arguments,
    add_mission_arguments,
    explained,
    mission_configuration,
)
from uav_tracking_mpc.report.mission_report import write_report
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.benchmark.command import add_parser as add_benchmark_parser
from uav_tracking_mpc.studies.comparison.command import add_parser as add_comparison_parser
from uav_tracking_mpc.studies.faults.command import add_torture_parser
from uav_tracking_mpc.studies.feasibility import command as feasibility
from uav_tracking_mpc.studies.stability.command import add_parser as add_stability_parser
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

EPILOG = """\
examples:
  uav_tracking simulate --config paper          the paper's simulation, no ROS needed
  uav_tracking fly --config paper               the same mission with three ROS 2 nodes
  uav_tracking fly --set nmpc_controller.model=paper
                                                the paper's model on the true vehicle
  uav_tracking stability --config paper         the paper's analysis, and a proof
  uav_tracking compare --config small_uav       NMPC beside classical laws, in wind
  uav_tracking simulate --config small_uav --scenario gusts
                                                one of these flights
  uav_tracking benchmark                        the solver beside its peers
  uav_tracking torture --minutes 10             faults injected into real nodes
  uav_tracking torture --soak 2                 hours of flight, watched for growth
  uav_tracking monitor --domain-id 7            watch a flight from another terminal
"""
BAG = "mission.mcap"


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; the exit code is that of :class:`uav_tracking_mpc.launch.Ending`."""
    parsed = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    with explained("uav_tracking") as ending:
        ending.code = int(parsed.run(parsed))
    return ending.code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="uav_tracking",
        description="Nonlinear MPC of a fixed-wing UAV that circles a ground target.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    fly = commands.add_parser("fly", help="fly a mission with real ROS 2 nodes, record and report")
    add_mission_arguments(fly)
    add_launch_arguments(fly)
    _add_output_arguments(fly)
    fly.set_defaults(run=_fly)

    simulated = commands.add_parser("simulate", help="the same mission without ROS, deterministic")
    add_mission_arguments(simulated)
    _add_output_arguments(simulated)
    simulated.set_defaults(run=_simulate)

    stability = add_stability_parser(commands, _stability_problem)
    add_configuration_arguments(stability)
    ellipsoid = stability.get_default("run")
    stability.set_defaults(run=lambda parsed: _stability(parsed, ellipsoid))

    add_configuration_arguments(add_comparison_parser(commands), default="small_uav")
    add_benchmark_parser(commands)
    add_torture_parser(commands)

    monitor = commands.add_parser("monitor", help="a live table of a flight in the terminal")
    monitor.add_argument(
        "--domain-id",
        type=domain_number,
        metavar="N",
        help="ROS domain to watch (default: ROS_DOMAIN_ID, or 0); a launch prints its own",
    )
    monitor.set_defaults(run=_monitor)
    return parser


def _add_output_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("output"),
        metavar="DIR",
        help="folder for metrics.json, figures and report.html (default: output)",
    )
    parser.add_argument(
        "--json", action="store_true", help="print the metrics as one JSON object, nothing else"
    )


def _simulate(arguments: argparse.Namespace) -> int:
    configuration = mission_configuration(arguments)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("simulating", total=configuration.mission.duration)
        log = simulate(configuration, lambda time: progress.update(task, completed=time))
    _finish(write_report(log, arguments.output), arguments)
    return 0


def _fly(arguments: argparse.Namespace) -> int:
    configuration = mission_configuration(arguments)
    bag = arguments.output / BAG
    number = launch(configuration, domain=arguments.domain_id, bag=bag)
    from uav_tracking_mpc.nodes.flight_bag import flight_log

    log = flight_log(bag, configuration)
    _finish(write_report(log, arguments.output), arguments)
    if number is None:
        return 0
    wanted = configuration.mission.duration
    print(f"interrupted: {log.duration:.1f} s of {wanted:g} s were flown", file=sys.stderr)
    return 128 + number


def _stability(
    arguments: argparse.Namespace, ellipsoid: Callable[[argparse.Namespace], int]
) -> int:
    """The analysis that fits the problem: of an artificial orbit, or of the paper's ellipsoid."""
    if arguments.verify is None and arguments.errata is None:
        configuration = load_configuration(arguments.config, arguments.overrides)
        if configuration.controller.terminal_constraint == ARTIFICIAL_ORBIT:
            return feasibility.run(arguments, configuration)
    return ellipsoid(arguments)


def _stability_problem(arguments: argparse.Namespace) -> StabilityProblem:
    configuration = load_configuration(arguments.config, arguments.overrides)
    return stability_problem(configuration.controller, configuration.name)


def _monitor(arguments: argparse.Namespace) -> int:
    if arguments.domain_id is not None:
        os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    from uav_tracking_mpc.nodes.monitor import Monitor
    from uav_tracking_mpc.nodes.run import run

    return run("monitor", Monitor, [])


def _finish(metrics: dict, arguments: argparse.Namespace) -> None:
    if arguments.json:
        print(json.dumps(metrics))
        return
    settling, steady = metrics["settling_s"], metrics["steady_state"]
    words = ", ".join(
        f"{name} {'never' if time is None else f'{time:.1f} s'}" for name, time in settling.items()
    )
    print(f"settled: {words}")
    rms = {name: steady[f"{name}_rms_m"] for name in ("range", "altitude")}
    words = ", ".join(
        f"{name} rms {'-' if value is None else f'{value:.4f} m'}" for name, value in rms.items()
    )
    print(f"last third: {words}")
    print(f"report: {arguments.output / 'report.html'}")


if __name__ == "__main__":
    sys.exit(main())
