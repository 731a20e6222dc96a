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
import signal
import sys
from pathlib import Path

from uav_tracking_mpc.cli.answer import answer
from uav_tracking_mpc.cli.arguments import (
    add_configuration_arguments,
    add_limit_argument,
    add_output_arguments,
    chosen_configuration,
    chosen_overrides,
    existing_file,
)

HELP = "the controller beside classical laws: in wind, about moving targets, told wrong"
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
    from uav_tracking_mpc.studies.comparison.law_names import law_names
    from uav_tracking_mpc.studies.comparison.mismatches import DURATION, MISMATCHES, SCENARIO

    add_configuration_arguments(parser, default="small_uav")
    add_limit_argument(parser)
    flown = parser.add_mutually_exclusive_group()
    flown.add_argument(
        "--scenario",
        nargs="+",
        metavar="NAME|FILE",
        help=f"some of {', '.join(scenario_names())} (default: all)",
    )
    flown.add_argument(
        "--mismatch",
        nargs="*",
        choices=MISMATCHES,
        metavar="NAME",
        help=f"instead: the scenario {SCENARIO} for {DURATION:g} s, told wrong; some of "
        f"{', '.join(MISMATCHES)} (without a name: all)",
    )
    laws = law_names()
    parser.add_argument("--laws", nargs="+", choices=laws, default=laws, help="laws that fly")
    parser.add_argument(
        "--law",
        dest="more_laws",
        action="append",
        default=[],
        metavar="FILE.py:CLASS",
        help="one more law; may be repeated",
    )
    add_output_arguments(
        parser, "compare.json, compare.html, figures; with --mismatch mismatches.json and so on"
    )
    parser.add_argument(
        "--page",
        type=existing_file,
        metavar="FILE",
        help="put the table into a page of the documentation",
    )


def run(arguments: argparse.Namespace) -> int:
    """Fly the comparison.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    laws = list(dict.fromkeys([*arguments.laws, *arguments.more_laws]))
    if arguments.mismatch is None:
        return _through_scenarios(arguments, laws)
    return _under_mismatches(arguments, laws)


def _through_scenarios(arguments: argparse.Namespace, laws: list[str]) -> int:
    from uav_tracking_mpc.studies.comparison.comparison_page import write_comparison
    from uav_tracking_mpc.studies.comparison.comparison_table import comparison_table, misses
    from uav_tracking_mpc.studies.comparison.flights import scenarios_in_order
    from uav_tracking_mpc.studies.comparison.results import as_json, compare

    names = list(dict.fromkeys(arguments.scenario or scenarios_in_order()))
    configurations = {Path(name).stem: chosen_configuration(arguments, name) for name in names}
    scenarios = compare(configurations, laws)
    whole = len(scenarios) == len(configurations)
    content = as_json(scenarios)
    table = comparison_table(scenarios)
    words = [table.as_rich(), *(f"missed, {line}" for line in misses(scenarios))]
    if arguments.output is not None:
        write_comparison(content, scenarios, arguments.output)
        words.append(f"report: {arguments.output / 'compare.html'}")
    if arguments.page is not None and whole:
        table.write_into(arguments.page, "comparison")
    answer(content, words, arguments.json)
    return _code(len(scenarios), len(configurations))


def _code(flown: int, asked: int) -> int:
    """Exit code, and on stderr what the user's interruption left out."""
    if flown == asked:
        return 0
    print(f"interrupted: {flown} of {asked} were flown by every law", file=sys.stderr)
    return 128 + signal.SIGINT


def _under_mismatches(arguments: argparse.Namespace, laws: list[str]) -> int:
    from uav_tracking_mpc.studies.comparison.comparison_page import write_mismatches
    from uav_tracking_mpc.studies.comparison.mismatch_results import mismatches_as_json
    from uav_tracking_mpc.studies.comparison.mismatch_table import mismatch_misses, mismatch_table
    from uav_tracking_mpc.studies.comparison.mismatches import (
        MISMATCHES,
        SCENARIO,
        mismatched,
        settled_after,
    )
    from uav_tracking_mpc.studies.comparison.results import compare

    names = [name for name in MISMATCHES if name in (arguments.mismatch or MISMATCHES)]
    overrides = tuple(chosen_overrides(arguments, SCENARIO))
    configurations = {name: mismatched(arguments.config, name, overrides) for name in names}
    after = settled_after(configurations[names[0]])
    mismatches = compare(configurations, laws, settled_after=after)
    whole = len(mismatches) == len(configurations)
    content = mismatches_as_json(mismatches)
    table = mismatch_table(mismatches)
    words = [table.as_rich(), *(f"missed, {line}" for line in mismatch_misses(mismatches))]
    if arguments.output is not None:
        write_mismatches(content, mismatches, arguments.output)
        words.append(f"report: {arguments.output / 'mismatches.html'}")
    if arguments.page is not None and whole:
        table.write_into(arguments.page, "mismatches")
    answer(content, words, arguments.json)
    return _code(len(mismatches), len(configurations))
