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

"""``uav_tracking identify``: how an aircraft answers commands, from a recorded flight."""

from __future__ import annotations

import argparse
from pathlib import Path

from uav_tracking_mpc.cli.options import add_configuration_arguments, add_output_arguments, number
from uav_tracking_mpc.cli.program import publish
from uav_tracking_mpc.parameters.specification import ParameterError

HELP = "lag, dead time, gain and limits of an aircraft, from a recorded flight"
DESCRIPTION = (
    "Fit first-order lag, dead time and gain of turn, path angle and speed to a flight that "
    "`fly --excite` or `simulate --excite` flew, or to any record with the same topics or columns "
    "(docs/identification.md). Prints 95 % confidence intervals and the YAML to paste. Exit code "
    "0: every channel was identified; 1: at least one was not."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    parser.add_argument(
        "record",
        nargs="?",
        type=Path,
        metavar="BAG|CSV",
        help="mission.mcap, the folder of a rosbag2 bag, or a CSV file",
    )
    content = "identification.json, identified.yaml and response.png"
    add_output_arguments(parser, content, page="the counts")
    parser.add_argument(
        "--validate",
        type=number(int, 1),
        metavar="N",
        help="instead of a record: fly N simulated flights with lags drawn at random, and count "
        "how often they are found",
    )
    parser.add_argument(
        "--workers", type=number(int, 1), metavar="N", help="processes (default: one a core)"
    )
    parser.add_argument("--seed", type=number(int, 0), default=0, help="of the flights' draws")
    add_configuration_arguments(parser, default="small_uav")


def run(arguments: argparse.Namespace) -> int:
    """Identify, or validate identification.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.

    Raises:
        ParameterError: Neither a record nor a validation is asked for, or the record is none.
    """
    if (arguments.record is None) == (arguments.validate is None):
        raise ParameterError("identify needs either a bag or CSV file, or --validate N")
    if arguments.record is not None and not arguments.record.exists():
        raise ParameterError(f"there is no bag or CSV file {str(arguments.record)!r}")
    if arguments.validate is not None:
        from uav_tracking_mpc.studies.identification.validation import validate

        study = validate(
            arguments.config,
            arguments.overrides,
            count=arguments.validate,
            seed=arguments.seed,
            workers=arguments.workers,
        )
        return publish(study, arguments)
    from rich.console import Console

    from uav_tracking_mpc.studies.identification.identification import identification

    with Console(stderr=True).status(f"identifying {arguments.record}"):
        study = identification(arguments.record)
    return publish(study, arguments)
