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

"""``uav_tracking fly``: a mission with real ROS 2 nodes, recorded and reported."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import (
    CONNECT_LIMIT,
    DOMAIN_WORDS,
    add_domain_argument,
    add_excite_argument,
    add_link_arguments,
    add_mission_arguments,
    add_output_arguments,
    add_view_argument,
    check_link_arguments,
    chosen_configuration,
    preflight_lines,
    told_page_arguments,
)
from uav_tracking_mpc.cli.program import answer
from uav_tracking_mpc.cli.view import check_page
from uav_tracking_mpc.parameters.specification import ParameterError

if TYPE_CHECKING:
    from rich.console import Console

    from uav_tracking_mpc.settings.configuration import Configuration

HELP = "fly a mission with real ROS 2 nodes, record and report"
DESCRIPTION = (
    "Start simulator, target and controller as processes, fly a mission and report it. With --link "
    "a real autopilot flies in the simulator's place: it is inspected first (see `link check`), "
    "its limits become the controller's, and the duration counts from when it is engaged. Nothing "
    "here arms it or takes off. Exit code 0: range, altitude, speed and bearing came to stay "
    "within 1 m, 1 m, 0.1 m/s and 0.05 rad of the orbit asked for, and as much further as gusts "
    "move an aircraft; 3: one of them never did, as in a short flight; 1: a node died."
)
BAG = "mission.mcap"
RECORD = "controller.jsonl"
NOT_SETTLED = 3  # exit code: some error did not settle


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_mission_arguments(parser, plant="uav_simulator.plant")
    add_excite_argument(parser)
    add_link_arguments(parser, flown=True)
    add_domain_argument(parser, DOMAIN_WORDS)
    add_view_argument(
        parser,
        "show the flight on a page, see `view`; it is flown and reported as without, then the page "
        "stays until Ctrl-C",
    )
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
    from rich.console import Console

    from uav_tracking_mpc.launch.flight import BrokenFlightError, launch
    from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT

    console, link = Console(stderr=True), arguments.link is not None
    bag, record = arguments.output / BAG, (arguments.output / RECORD).resolve()
    unfinished = record.with_name(f".{RECORD}")  # the last flight's stays until this one flew
    setting = f"nmpc_controller.record={json.dumps(str(unfinished))}"
    arguments.overrides = [setting, *arguments.overrides]
    check_link_arguments(arguments)
    page_words = told_page_arguments(arguments)
    if link:
        arguments.overrides = [*arguments.overrides, "mission.speed=1.0"]  # real time has one
    configuration = chosen_configuration(arguments, arguments.scenario)
    if link and configuration.controller.terminal_constraint != ARTIFICIAL_ORBIT:
        raise ParameterError(
            f"configuration {configuration.name!r} knows no limits of an aircraft, which a link "
            "needs (terminal_constraint 'artificial_orbit'): fly --config small_uav, or one of "
            "your own"
        )
    number: int | None = None
    died: BrokenFlightError | None = None
    with ExitStack() as stack:
        stay = (
            stack.enter_context(_page(arguments, page_words, console)) if arguments.view else None
        )
        try:
            with ExitStack() as autopilot:
                if link:
                    configuration = _inspected(configuration, arguments, console, autopilot)
                number = launch(
                    configuration, domain=arguments.domain_id, bag=bag, console=console, link=link
                )
        except BrokenFlightError as error:
            died = error
        except BaseException:
            unfinished.unlink(missing_ok=True)
            raise
        if unfinished.exists():  # not where a file of its own was asked for
            unfinished.replace(record)
        code = _reported(configuration, arguments, bag, number, died is None)
        if died is not None:
            raise died
        if stay is not None and number is None:
            stay()
    return code


@contextmanager
def _page(
    arguments: argparse.Namespace, words: Sequence[str], console: Console
) -> Iterator[Callable[[], None]]:
    """A page of the domain in which is flown from now on; yields what waits for its end."""
    from uav_tracking_mpc.launch.flight import page_process
    from uav_tracking_mpc.launch.supervisor import own_domain
    from uav_tracking_mpc.nodes.ros.ros_environment import exported_domain

    check_page()
    asked = exported_domain() if arguments.domain_id is None else arguments.domain_id
    with own_domain(asked) as domain:
        if asked is None:
            arguments.domain_id = domain
        with page_process(domain, words, console) as stay:
            yield stay


def _reported(
    configuration: Configuration,
    arguments: argparse.Namespace,
    bag: Path,
    number: int | None,
    whole: bool,
) -> int:
    """Report what was flown until its end, until a signal came or a node died; exit code."""
    from uav_tracking_mpc.launch.supervisor import LaunchError
    from uav_tracking_mpc.nodes.bag_log import flight_log, last_complaint, not_recorded
    from uav_tracking_mpc.report.metrics import in_short, unsettled
    from uav_tracking_mpc.report.mission_report import write_report
    from uav_tracking_mpc.view.recorded_scene import recorded_scene

    try:
        log = flight_log(bag, configuration)
    except ValueError as error:
        raise LaunchError(f"no report: {error}") from error
    metrics = write_report(log, arguments.output, recorded_scene)
    answer(metrics, in_short(metrics, arguments.output), arguments.json)
    if words := not_recorded(bag):
        print(words, file=sys.stderr)
    if number is None and whole:
        if words := unsettled(metrics):
            said = f"not settled in {log.duration:.1f} s: {words}", last_complaint(bag)
            print(" ".join("; ".join(filter(None, said)).split()), file=sys.stderr)
        return NOT_SETTLED if words else 0
    wanted = configuration.mission.duration
    why = "broken off" if number is None else "interrupted"
    print(f"{why}: {log.duration:.1f} s of {wanted:g} s were flown", file=sys.stderr)
    return 1 if number is None else 128 + number


def _inspected(
    configuration: Configuration, arguments: argparse.Namespace, console: Console, stack: ExitStack
) -> Configuration:
    """Look at the autopilot, a simulated one on the stack, and have a solver that is fast enough.

    Returns:
        What is flown, with the limits of the autopilot.
    """
    from uav_tracking_mpc.control.guidance import compile_flight, compiled_into
    from uav_tracking_mpc.launch.flight import autopilot_process
    from uav_tracking_mpc.launch.preflight import preflight, refuse
    from uav_tracking_mpc.mpc.compiled_method import CompilationError
    from uav_tracking_mpc.mpc.machine_code import finished

    if arguments.simulated:
        place = stack.enter_context(autopilot_process(configuration, console))
        configuration = configuration.changed("autopilot_link", {"connection": place})
    found = preflight(configuration, CONNECT_LIMIT)
    for line in preflight_lines(found):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    refuse(found)
    tracking = found.configuration.controller
    try:
        folder = compiled_into(tracking)
        if folder is not None and not finished(folder):
            # An autopilot does not wait while another solver thinks for too long.
            console.print("compiling the solver, once on this computer: about ten seconds")
            compile_flight(tracking)
    except (CompilationError, NotImplementedError) as error:
        console.print(f"the solver cannot be compiled, another one flies: {error}", markup=False)
    return found.configuration
