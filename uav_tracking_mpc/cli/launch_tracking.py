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

"""``launch_tracking``: start the nodes and watch over them."""
# PYTHON_ARGCOMPLETE_OK

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress

from uav_tracking_mpc.cli.options import (
    DOMAIN_WORDS,
    add_domain_argument,
    add_mission_arguments,
    chosen_configuration,
)
from uav_tracking_mpc.cli.program import CommandParser, explained, offer


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the executable.

    Args:
        arguments: Command line without the program's name; that of the process by default.

    Returns:
        Exit code, see :class:`uav_tracking_mpc.cli.program.Ending`.
    """
    offer(lambda _: _parser())
    parsed = _parser().parse_args(arguments)
    from uav_tracking_mpc.launch.flight import FlightInterruptedError, launch

    # A launcher runs until somebody ends it: a signal is no failure, as for a node.
    with explained("launch_tracking") as ending, suppress(FlightInterruptedError):
        launch(chosen_configuration(parsed, parsed.scenario), domain=parsed.domain_id)
    return ending.code


def _parser() -> CommandParser:
    parser = CommandParser(
        prog="launch_tracking",
        description="Start simulator, target and controller as processes and watch over them. "
        "Ctrl-C ends them all.",
    )
    add_mission_arguments(parser, plant="uav_simulator.plant")
    add_domain_argument(parser, DOMAIN_WORDS)
    return parser


if __name__ == "__main__":
    sys.exit(main())
