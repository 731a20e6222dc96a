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

"""``uav_tracking engage``: command of a flight that is under way, taken and given back."""

from __future__ import annotations

import argparse

from uav_tracking_mpc.cli.flight_requests import add_flight_arguments, appears, flight_requests

HELP = "let the controller command a flight that is under way, or give command back"
DESCRIPTION = (
    "Engage: the controller sends commands and, where autopilot_link flies a real autopilot, that "
    "flies them. With --off command is given back: a real autopilot goes on as it does by itself, "
    "a simulated aircraft flies its plan to the end, then holds its wings level. It calls the "
    "services nmpc_controller/engage and autopilot_link/engage. Exit code 0: done; 2: refused, and "
    "why; 1: there is no such node."
)
CONTROLLER, LINK = "nmpc_controller/engage", "autopilot_link/engage"
SIMULATOR = "uav_simulator/pause"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument("--off", action="store_true", help="give command back")
    add_flight_arguments(parser, "engage")


def run(arguments: argparse.Namespace) -> int:
    """Engage or disengage.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.

    Raises:
        ParameterError: It was refused.
    """
    from uav_tracking_mpc.parameters.specification import ParameterError

    with flight_requests(arguments, switches=(CONTROLLER, LINK, SIMULATOR)) as requests:
        # Either may be found first; without a link or a simulator a stranger flies.
        appears(
            lambda: (
                (arguments.off and requests.offered(LINK))
                or (
                    requests.offered(CONTROLLER)
                    and (requests.offered(LINK) or requests.offered(SIMULATOR))
                )
            )
        )
        there = [service for service in (CONTROLLER, LINK) if requests.offered(service)]
        if arguments.off:
            there = there[-1:]
        for service in there or [CONTROLLER]:
            if refused := requests.call(service, data=not arguments.off):
                raise ParameterError(f"{service}: {refused}")
            print(f"{service}: {'off' if arguments.off else 'on'}")
    return 0
