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

"""``uav_tracking simulate``: a mission without ROS."""

from __future__ import annotations

import argparse
import logging
import sys

from uav_tracking_mpc.cli.options import (
    add_excite_argument,
    add_mission_arguments,
    add_output_arguments,
    add_view_argument,
    chosen_configuration,
    told_page_arguments,
)
from uav_tracking_mpc.cli.program import answer
from uav_tracking_mpc.cli.view import check_page, opened_page, serve_until_signal

logger = logging.getLogger(__name__)

HELP = "the same mission without ROS, deterministic"
DESCRIPTION = (
    "Fly a mission without ROS: plant and controller in turn, the same every time. With --view it "
    "is flown at the configuration's mission.speed and shown on a page, where it is steered, until "
    "Ctrl-C, whatever its duration; the report is of all that was flown. Exit code 1: a guidance "
    "law was to fly, and answered no command."
)
RECORD = "record.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_mission_arguments(parser, plant="mission.plant", without=["speed"])
    add_excite_argument(parser)
    add_output_arguments(
        parser, "metrics.json, figures and report.html; with an excitation record.csv", "output"
    )
    parser.add_argument(
        "--animation", action="store_true", help="also draw flight.gif, the flight from above"
    )
    add_view_argument(parser, "watch and steer the flight on a page, until Ctrl-C")


def run(arguments: argparse.Namespace) -> int:
    """Simulate and report.

    Args:
        arguments: As parsed.

    Returns:
        Exit code; 1 where the guidance law answered no command.
    """
    from rich.console import Console
    from rich.progress import Progress

    from uav_tracking_mpc.margins.margin_check import margin_warning
    from uav_tracking_mpc.report.metrics import in_short
    from uav_tracking_mpc.report.mission_report import write_report
    from uav_tracking_mpc.simulation.closed_loop import simulate
    from uav_tracking_mpc.studies.identification.flight_record import FlightWitness, write_record
    from uav_tracking_mpc.view.recorded_scene import recorded_scene

    told_page_arguments(arguments)
    configuration = chosen_configuration(arguments, arguments.scenario)
    warning = margin_warning(configuration.controller)
    if warning:
        logger.warning(warning)
    witness = FlightWitness() if any(configuration.controller.excitation) else None
    if arguments.view:
        from uav_tracking_mpc.view.simulated_source import SimulatedSource

        check_page()
        source = SimulatedSource(configuration, witness)
        with opened_page(source, arguments) as page:
            serve_until_signal(page, source)
        log = source.log()
    else:
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("simulating", total=configuration.mission.duration)
            log = simulate(
                configuration, lambda time: progress.update(task, completed=time), witness=witness
            )
    metrics = write_report(log, arguments.output, recorded_scene)
    if witness is not None:
        write_record(witness.record(), arguments.output / RECORD)
    if arguments.animation:
        from uav_tracking_mpc.report.animation import save_animation

        save_animation(log, arguments.output / "flight.gif")
    answer(metrics, in_short(metrics, arguments.output), arguments.json)
    if log.not_by_law:
        print(log.not_by_law, file=sys.stderr)
    return 1 if log.not_by_law else 0
