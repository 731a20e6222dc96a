"""``uav_tracking compare``: every law through every scenario, measured by the same rule.

With ``--json`` one JSON object goes to stdout and nothing else; progress goes to stderr. Exit code
0: flown; whether the targets are reached is said in the table.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.settings.configuration import load_configuration, scenario_names
from uav_tracking_mpc.studies.comparison.comparison_page import write_comparison
from uav_tracking_mpc.studies.comparison.comparison_table import (
    as_markdown,
    as_table,
    misses,
    write_into,
)
from uav_tracking_mpc.studies.comparison.flights import LAWS, fly_all
from uav_tracking_mpc.studies.comparison.results import Scenario, as_json, scenario_of

ORDER = (
    "still", "wind", "crosswind", "headwind", "tight_headwind", "circling_target", "gusts",
    "noisy_target",
)  # fmt: skip

WIDTH = 134  # characters of the table


def add_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add the command ``compare``; its caller adds the options that choose a configuration.

    Args:
        subparsers: What ``add_subparsers`` returned.

    Returns:
        The parser; its ``run`` default takes the parsed arguments and returns the exit code.
    """
    parser = subparsers.add_parser(
        "compare",
        help="the controller beside two classical laws, in wind and about moving targets",
        description="Fly all laws through all scenarios; print and plot how they do.",
    )
    parser.add_argument(
        "--scenario",
        nargs="+",
        metavar="NAME|FILE",
        default=None,
        help=f"some of {', '.join(scenario_names())} (default: all)",
    )
    parser.add_argument(
        "--laws", nargs="+", choices=LAWS, default=list(LAWS), help="(default: all)"
    )
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder for compare.json, compare.html, figures"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")
    parser.add_argument(
        "--page", type=Path, metavar="FILE", help="put the table into a page of the documentation"
    )
    parser.set_defaults(run=main)
    return parser


def main(arguments: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    names = list(dict.fromkeys(arguments.scenario or _all_scenarios()))
    laws = list(dict.fromkeys(arguments.laws))
    scenarios = compare(arguments.config, arguments.overrides, names, laws)
    numbers = as_json(scenarios[0].configuration.name, scenarios)
    if arguments.output is not None:
        write_comparison(numbers, scenarios, arguments.output)
    if arguments.page is not None:
        write_into(arguments.page, as_markdown(scenarios))
    if arguments.json:
        print(json.dumps(numbers))
        return 0
    console = Console()
    # At least as wide as it needs: a table that is cut tells nothing.
    console.width = max(console.width, WIDTH)
    console.print(as_table(scenarios))
    for words in misses(scenarios):
        console.print(f"missed, {words}", markup=False, highlight=False, soft_wrap=True)
    if arguments.output is not None:
        console.print(f"report: {arguments.output / 'compare.html'}", highlight=False)
    return 0


def compare(
    config: str, overrides: Sequence[str], names: Sequence[str], laws: Sequence[str]
) -> list[Scenario]:
    """Fly laws through scenarios.

    Args:
        config: Name or file of the configuration.
        overrides: Of its parameters, in every scenario.
        names: Names or files of the scenarios.
        laws: Names of the laws.

    Raises:
        ParameterError: A configuration or scenario is not there or not allowed.
    """
    configurations = [load_configuration(config, overrides, name) for name in names]
    flights = fly_all(configurations, laws)
    return [
        scenario_of(Path(name).stem, configuration, laws, logs)
        for name, configuration, logs in zip(names, configurations, flights, strict=True)
    ]


def _all_scenarios() -> list[str]:
    """From easy to hard, then whatever else there is."""
    names = scenario_names()
    return [*(name for name in ORDER if name in names), *(set(names) - set(ORDER))]
