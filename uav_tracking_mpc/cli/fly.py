"""``uav_tracking fly``: a mission with real ROS 2 nodes, recorded and reported."""

from __future__ import annotations

import argparse
import json
import sys

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import (
    add_domain_argument,
    add_excite_argument,
    add_mission_arguments,
    add_output_arguments,
    chosen_configuration,
)

HELP = "fly a mission with real ROS 2 nodes, record and report"
DESCRIPTION = "Start simulator, target and controller as processes, fly a mission and report it."
BAG = "mission.mcap"
RECORD = "controller.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_mission_arguments(parser, plant="uav_simulator.plant")
    add_excite_argument(parser)
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
    configuration = chosen_configuration(arguments, arguments.scenario)
    try:
        number = launch(configuration, domain=arguments.domain_id, bag=bag)
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
