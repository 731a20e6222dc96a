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

"""``uav_tracking link check``: what an autopilot says before a flight, and what follows from it."""

from __future__ import annotations

import argparse

from uav_tracking_mpc.cli.options import (
    CONNECT_LIMIT,
    add_configuration_arguments,
    add_link_arguments,
    chosen_configuration,
    number,
    preflight_lines,
)
from uav_tracking_mpc.cli.program import answer

HELP = "what a real autopilot says before a flight"
DESCRIPTION = "Look at an autopilot. Nothing is commanded, and nothing is changed there."
CHECK = (
    "Connect to an autopilot, read its firmware, mode, limits and failsafes, and say what envelope "
    "follows and whether the configuration's orbit fits it in the wind there. Exit code 0: it can "
    "be flown; 2: it cannot, and why."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    actions = parser.add_subparsers(
        dest="action", required=True, metavar="ACTION", help="what to do"
    )
    check = actions.add_parser("check", help=HELP, description=CHECK)
    add_configuration_arguments(check, default="small_uav")
    add_link_arguments(check, flown=False)
    check.add_argument(
        "--timeout",
        type=number(float, 0.1, 600.0),
        default=CONNECT_LIMIT,
        metavar="S",
        help="how long to look for the autopilot",
    )
    check.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def run(arguments: argparse.Namespace) -> int:
    """Check an autopilot.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.launch.preflight import preflight, refuse

    configuration = chosen_configuration(arguments)
    found = preflight(configuration, arguments.timeout)
    inspection = found.inspection
    content = {
        "link": configuration.link.link,
        "config": configuration.name,
        "found": dict(inspection.found),
        "envelope": dict(inspection.envelope),
        "changes": list(found.changes),
        "wind_mps": None if found.wind is None else found.wind.tolist(),
        "warnings": list(inspection.warnings),
        "refusals": list(found.refusals),
    }
    answer(content, preflight_lines(found), arguments.json)
    refuse(found)
    return 0
