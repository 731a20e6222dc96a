"""``uav_tracking simulate``: a mission without ROS."""

from __future__ import annotations

import argparse
import logging

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import (
    add_excite_argument,
    add_mission_arguments,
    add_output_arguments,
    chosen_configuration,
)

logger = logging.getLogger(__name__)

HELP = "the same mission without ROS, deterministic"
DESCRIPTION = "Fly a mission without ROS: plant and controller in turn, the same every time."
RECORD = "record.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_mission_arguments(parser, plant="mission.plant")
    add_excite_argument(parser)
    add_output_arguments(
        parser, "metrics.json, figures and report.html; with an excitation record.csv", "output"
    )
    parser.add_argument(
        "--animation", action="store_true", help="also draw flight.gif, the flight from above"
    )


def run(arguments: argparse.Namespace) -> int:
    """Simulate and report.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from rich.console import Console
    from rich.progress import Progress

    from uav_tracking_mpc.control.margin_check import margin_warning
    from uav_tracking_mpc.report.flight_findings import in_short
    from uav_tracking_mpc.report.mission_report import write_report
    from uav_tracking_mpc.simulation.closed_loop import simulate
    from uav_tracking_mpc.studies.identification.csv_record import FlightWitness, write_record

    configuration = chosen_configuration(arguments, arguments.scenario)
    warning = margin_warning(configuration.controller)
    if warning:
        logger.warning(warning)
    witness = FlightWitness() if any(configuration.controller.excitation) else None
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("simulating", total=configuration.mission.duration)
        log = simulate(
            configuration, lambda time: progress.update(task, completed=time), witness=witness
        )
    metrics = write_report(log, arguments.output)
    if witness is not None:
        write_record(witness.record(), arguments.output / RECORD)
    if arguments.animation:
        from uav_tracking_mpc.report.animation import save_animation

        save_animation(log, arguments.output / "flight.gif")
    answer(metrics, in_short(metrics, arguments.output), arguments.json)
    return 0
