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

"""``uav_tracking compare``: every law through every scenario, measured by the same rule."""

from __future__ import annotations

import argparse
from pathlib import Path

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_limit_argument,
    add_output_arguments,
    chosen_configuration,
    chosen_overrides,
)
from uav_tracking_mpc.cli.program import publish
from uav_tracking_mpc.parameters.specification import ParameterError

HELP = "the controller beside classical laws: in wind, about moving targets, with wrong settings"
DESCRIPTION = (
    "Fly all laws through all scenarios, or with --mismatch where lag, delay, noise, biases or air "
    "are other than the controller was told; print and plot how they do. Exit code 0: flown; "
    "whether what is asked of nmpc is reached is said in the table."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    from uav_tracking_mpc.settings.configuration import scenario_names
    from uav_tracking_mpc.studies.comparison.scenarios import (
        DURATION,
        MISMATCHES,
        SCENARIO,
        law_names,
    )

    add_configuration_arguments(parser, default="small_uav")
    add_limit_argument(parser)
    flown = parser.add_mutually_exclusive_group()
    flown.add_argument(
        "--scenario",
        nargs="+",
        action="extend",
        metavar="NAME|FILE",
        help=f"some of {', '.join(scenario_names())} (default: all)",
    )
    flown.add_argument(
        "--mismatch",
        nargs="*",
        action="extend",
        choices=MISMATCHES,
        metavar="NAME",
        help=f"instead: the scenario {SCENARIO} for {DURATION:g} s, each time with one thing other "
        "than told; some of "
        f"{', '.join(MISMATCHES)} (without a name: all)",
    )
    parser.add_argument(
        "--plant",
        metavar="NAME",
        help="fly it instead of the configuration's plant, e.g. jsbsim; files and keys are then "
        "named by it, e.g. mismatches_jsbsim",
    )
    laws = law_names()
    parser.add_argument(
        "--laws",
        nargs="+",
        action="extend",
        choices=laws,
        metavar="LAW",
        help=f"laws that fly: some of {', '.join(laws)} (default: all)",
    )
    parser.add_argument(
        "--law",
        dest="more_laws",
        action="append",
        default=[],
        metavar="FILE.py:CLASS",
        help="one more law; may be repeated",
    )
    add_output_arguments(
        parser,
        "compare.json, compare.html, figures; with --mismatch mismatches.json and so on",
        page="the table",
    )


def run(arguments: argparse.Namespace) -> int:
    """Fly the comparison.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.studies.comparison import scenarios
    from uav_tracking_mpc.studies.comparison.figures import comparison
    from uav_tracking_mpc.studies.comparison.results import MISTOLD, SCENARIOS, compare

    laws = list(dict.fromkeys([*(arguments.laws or scenarios.law_names()), *arguments.more_laws]))
    if arguments.plant is not None:
        arguments.overrides = [*arguments.overrides, f"uav_simulator.plant={arguments.plant}"]
    if arguments.mismatch is None:
        names = dict.fromkeys(arguments.scenario or scenarios.scenarios_in_order())
        stems = [Path(name).stem for name in names]
        if len(set(stems)) < len(stems):
            raise ParameterError(
                f"scenarios are {', '.join(names)}, each must have a name of its own"
            )
        configurations = {
            stem: chosen_configuration(arguments, name)
            for stem, name in zip(stems, names, strict=True)
        }
        kind, after = SCENARIOS, None
    else:
        asked = arguments.mismatch or scenarios.MISMATCHES
        overrides = tuple(chosen_overrides(arguments, scenarios.SCENARIO))
        configurations = {
            name: scenarios.mismatched(arguments.config, name, overrides)
            for name in scenarios.MISMATCHES
            if name in asked
        }
        kind, after = MISTOLD, scenarios.settled_after(next(iter(configurations.values())))
    if arguments.plant is not None:
        kind = kind.on(arguments.plant)
    flown, left = compare(configurations, laws, settled_after=after), ""
    if len(flown) < len(configurations):
        left = f"{len(flown)} of {len(configurations)} were flown by every law"
    return publish(comparison(flown, kind, left), arguments)
