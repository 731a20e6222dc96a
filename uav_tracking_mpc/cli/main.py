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

"""The ``uav_tracking`` command."""
# PYTHON_ARGCOMPLETE_OK

from __future__ import annotations

import argparse
import importlib
import logging
import sys
from collections.abc import Sequence

from uav_tracking_mpc import __version__
from uav_tracking_mpc.cli.program import CommandParser, check_writable, explained, offer

COMMANDS = (
    "fly", "view", "autopilot", "link", "simulate", "compare", "campaign", "margins", "identify",
    "stability", "benchmark", "compile", "torture", "monitor",
    "engage", "set",
)  # fmt: skip
EPILOG = """\
examples:
  uav_tracking simulate --config paper          the paper's simulation, no ROS needed
  uav_tracking fly --config paper               the same mission with three ROS 2 nodes
  uav_tracking fly --set nmpc_controller.model=paper
                                                the paper's model on the true vehicle
  uav_tracking fly --link ardupilot --simulated --engage --config small_uav
                                                through a simulated autopilot, over MAVLink
  uav_tracking link check --link ardupilot --connection udpin:127.0.0.1:14550 --config small_uav
                                                what a real autopilot says before a flight
  uav_tracking stability --config paper         the paper's analysis, and a proof
  uav_tracking compare --config small_uav       NMPC beside classical laws, in wind
  uav_tracking compare --law pursuit.py:Pursuit a law of your own beside them
  uav_tracking simulate --config small_uav --scenario gusts
                                                one of these flights
  uav_tracking campaign robustness --flights 40 random flights, and how many fail
  uav_tracking margins                          how much more lag and gain the loop bears
  uav_tracking simulate --config small_uav --excite --output out
  uav_tracking identify out/record.csv          lag and dead time from this flight
  uav_tracking benchmark                        the solver beside its peers
  uav_tracking compile --config small_uav       compile the solver before the first flight
  uav_tracking torture --minutes 10             faults injected into real nodes
  uav_tracking torture --soak 2                 hours of flight, watched for growth
  uav_tracking view output/mission.mcap         a recorded flight on a page in the browser
  uav_tracking monitor --domain-id 7            watch a flight from another terminal
  uav_tracking set nmpc_controller.range=350 --domain-id 7
                                                change it meanwhile
  uav_tracking engage --off --domain-id 7       give command back, or take it without --off
  uav_tracking autopilot --dialect ardupilot    a simulated ArduPlane behind MAVLink
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of ``uav_tracking``.

    Args:
        arguments: Command line without the program's name; that of the process by default.

    Returns:
        Exit code, see :class:`uav_tracking_mpc.cli.program.Ending`.
    """
    offer(_parser)
    words = sys.argv[1:] if arguments is None else list(arguments)
    with explained("uav_tracking") as ending:
        parsed = _parser(words).parse_args(words)
        logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
        if getattr(parsed, "output", None) is not None:
            check_writable(parsed.output)
        ending.code = int(parsed.run(parsed))
    return ending.code


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="uav_tracking",
        description="Nonlinear MPC of a fixed-wing UAV that circles a ground target.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    asked = next((word for word in words if not word.startswith("-")), None)
    for name in COMMANDS:
        module = importlib.import_module(f"uav_tracking_mpc.cli.{name}")
        command = commands.add_parser(name, help=module.HELP, description=module.DESCRIPTION)
        command.set_defaults(run=module.run)
        if name == asked:  # options name configurations and extensions, which takes time to find
            module.add_arguments(command)
    return parser


if __name__ == "__main__":
    sys.exit(main())
