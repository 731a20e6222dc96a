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

"""``uav_tracking torture``: fly real nodes under faults, and report what came of it."""

from __future__ import annotations

import argparse
import itertools
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_domain_argument,
    add_output_arguments,
    chosen_configuration,
    number,
)
from uav_tracking_mpc.cli.program import publish

if TYPE_CHECKING:
    from rich.console import Console

    from uav_tracking_mpc.studies.faults.schedule import Case
    from uav_tracking_mpc.studies.study import Study

HELP = "inject faults into real nodes and check that nothing breaks"
DESCRIPTION = (
    "Fly with real nodes, inject faults from a seeded schedule, check every message. Or fly for "
    "hours without faults (--soak), or a simulated autopilot with faults on its wire (--link). "
    "Exit code 0 if nothing was violated and no process was lost."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    add_configuration_arguments(parser, "small_uav")
    add_domain_argument(parser, "ROS domain to fly in (default: one that no other launch uses)")
    parser.add_argument(
        "--minutes", type=number(float, 0.01, 1e4), default=10.0, help="wall time of faults [min]"
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        dest="faults",
        metavar="FILE.py:CLASS",
        help="a fault of your own, injected before all others; may be repeated",
    )
    parser.add_argument(
        "--soak",
        type=number(float, 0.1, 1000.0),
        metavar="HOURS",
        help="instead: hours of simulated flight without faults",
    )
    parser.add_argument(
        "--link",
        choices=("ardupilot", "px4"),
        help="instead: faults on the wire to a simulated autopilot, in simulated time, without ROS",
    )
    parser.add_argument(
        "--cases", type=number(int, 1, 100_000), default=54, help="how many faults on the wire"
    )
    parser.add_argument(
        "--seed", type=number(int, 0), default=0, metavar="N", help="of everything random"
    )
    parser.add_argument(
        "--case",
        type=number(int, 0),
        metavar="N",
        help="only this case of the schedule, to see it again",
    )
    add_output_arguments(
        parser,
        "torture.json, timeline.png, nodes.log and the bags of failing cases",
        "output/torture",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the campaign.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from rich.console import Console

    arguments.output.mkdir(parents=True, exist_ok=True)
    # SIGTERM ends the campaign as Ctrl-C does.
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        fly = _soak if arguments.soak else _link if arguments.link else _nodes
        return publish(fly(arguments, Console(stderr=True)), arguments)
    finally:
        signal.signal(signal.SIGTERM, previous)


def _soak(arguments: argparse.Namespace, console: Console) -> Study:
    from uav_tracking_mpc.studies.faults.node_campaign import SOAK_SPEED, soak

    arguments.overrides = [f"mission.speed={SOAK_SPEED!r}", *arguments.overrides]
    return soak(
        chosen_configuration(arguments),
        arguments.soak,
        arguments.output,
        console,
        arguments.domain_id,
    )


def _link(arguments: argparse.Namespace, console: Console) -> Study:
    from uav_tracking_mpc.studies.faults.link_campaign import LINK_FAULTS, LinkCampaign
    from uav_tracking_mpc.studies.faults.schedule import schedule

    configuration = chosen_configuration(arguments, "crosswind")
    cases = _chosen(arguments, schedule(LINK_FAULTS, arguments.seed, most=1), arguments.cases)
    return LinkCampaign(arguments.link, configuration, console).fly(cases, seed=arguments.seed)


def _nodes(arguments: argparse.Namespace, console: Console) -> Study:
    from uav_tracking_mpc.studies.faults.node_campaign import NodeCampaign
    from uav_tracking_mpc.studies.faults.schedule import catalogue, schedule, variants

    configuration, seed, minutes = (
        chosen_configuration(arguments), arguments.seed, arguments.minutes
    )  # fmt: skip
    faults = catalogue(arguments.faults)
    first = [label for reference in arguments.faults for label in variants(reference)]
    for bag in (arguments.output / "cases").glob("case_*.mcap"):
        bag.unlink()  # of another run
    cases = _chosen(arguments, schedule(faults, seed, minutes, first))
    flown = NodeCampaign(configuration, faults, arguments.output, console)
    return flown.fly(cases, seed=seed, minutes=minutes, domain=arguments.domain_id)


def _chosen(
    arguments: argparse.Namespace, cases: Iterator[Case], count: int | None = None
) -> Iterator[Case]:
    """The cases to fly of a schedule without end: one, or the first so many; all by default."""
    if arguments.case is None:
        return itertools.islice(cases, count)
    return itertools.islice(cases, arguments.case, arguments.case + 1)
