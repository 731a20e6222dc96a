"""``uav_tracking fly``: a mission with real ROS 2 nodes, recorded and reported."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import (
    add_domain_argument,
    add_excite_argument,
    add_mission_arguments,
    add_output_arguments,
    chosen_configuration,
)
from uav_tracking_mpc.cli.link_arguments import (
    CONNECT_LIMIT,
    add_link_arguments,
    check_link_arguments,
    preflight_lines,
    told_names,
    with_connection,
)

if TYPE_CHECKING:
    from uav_tracking_mpc.settings.configuration import Configuration

HELP = "fly a mission with real ROS 2 nodes, record and report"
DESCRIPTION = (
    "Start simulator, target and controller as processes, fly a mission and report it. With --link "
    "a real autopilot flies in the simulator's place: it is looked at first (see `link check`), "
    "its limits become the controller's, and the duration counts from when it is engaged. Nothing "
    "here arms it or takes off."
)
BAG = "mission.mcap"
RECORD = "controller.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_mission_arguments(parser, plant="uav_simulator.plant")
    add_excite_argument(parser)
    add_link_arguments(parser, flown=True)
    add_domain_argument(parser, "ROS domain to fly in (default: one that no other launch uses)")
    add_output_arguments(
        parser, f"{BAG}, {RECORD}, metrics.json, figures and report.html", "output"
    )


def run(arguments: argparse.Namespace) -> int:
    """Fly, and report what was flown even where a signal ended the flight.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.launch.flight import launch

    bag, record = arguments.output / BAG, (arguments.output / RECORD).resolve()
    setting = f"nmpc_controller.record={json.dumps(str(record))}"
    arguments.overrides = [setting, *arguments.overrides]
    check_link_arguments(arguments)
    if arguments.link is not None:
        arguments.overrides = [*arguments.overrides, "mission.speed=1.0"]  # real time has one
    configuration = chosen_configuration(arguments, arguments.scenario)
    try:
        if arguments.link is None:
            number = launch(configuration, domain=arguments.domain_id, bag=bag)
        else:
            number, configuration = _fly_link(configuration, arguments, bag)
    except BaseException:
        record.unlink(missing_ok=True)
        raise
    from uav_tracking_mpc.nodes.flight_bag import flight_log
    from uav_tracking_mpc.report.flight_findings import in_short
    from uav_tracking_mpc.report.mission_report import write_report

    log = flight_log(bag, configuration)
    metrics = write_report(log, arguments.output)
    answer(metrics, in_short(metrics, arguments.output), arguments.json)
    if number is None:
        return 0
    wanted = configuration.mission.duration
    print(f"interrupted: {log.duration:.1f} s of {wanted:g} s were flown", file=sys.stderr)
    return 128 + number


def _fly_link(
    configuration: Configuration, arguments: argparse.Namespace, bag: Path
) -> tuple[int | None, Configuration]:
    """Look at the autopilot, then fly it; what was flown has its limits."""
    from rich.console import Console

    from uav_tracking_mpc.launch.autopilot_process import autopilot_process
    from uav_tracking_mpc.launch.flight import launch
    from uav_tracking_mpc.launch.preflight import preflight, refuse

    console = Console(stderr=True)
    with ExitStack() as stack:
        if arguments.simulated:
            place = stack.enter_context(autopilot_process(configuration, console))
            configuration = with_connection(configuration, place)
        found = preflight(configuration, told_names(arguments), CONNECT_LIMIT)
        for line in preflight_lines(found):
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        refuse(found)
        flown = found.configuration
        number = launch(flown, domain=arguments.domain_id, bag=bag, console=console, link=True)
    return number, flown
