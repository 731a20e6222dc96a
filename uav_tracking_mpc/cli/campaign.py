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

"""``uav_tracking campaign``: many flights of what is uncertain, and how many of them fail."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path

from uav_tracking_mpc.cli.options import add_output_arguments, number
from uav_tracking_mpc.cli.program import check_writable, publish

HELP = "Monte-Carlo over what is uncertain, on all cores or on a Dask cluster"
DESCRIPTION = (
    "Fly what a campaign's file draws; print and plot how often flights fail, with exact bounds, "
    "and what those that fail have in common. A campaign that was stopped goes on where it was: "
    "what its folder holds is not flown again. Exit code 0: flown; how many failed is said in the "
    "table; 130: interrupted, what was flown until then is kept and reported."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Args:
        parser: Of this command.
    """
    from uav_tracking_mpc.settings.configuration import campaign_names
    from uav_tracking_mpc.studies.comparison.scenarios import law_names

    names = ", ".join(campaign_names())
    parser.add_argument("campaign", metavar="NAME|FILE", help=f"{names}, or a YAML file")
    parser.add_argument(
        "--laws",
        nargs="+",
        action="extend",
        metavar="LAW",
        help=f"laws that fly the same draws: {', '.join(law_names())} or FILE.py:CLASS (default: "
        "the campaign's)",
    )
    parser.add_argument(
        "--flights",
        type=number(int, 1),
        metavar="N",
        help="draws of each combination of swept values (default: the campaign's)",
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a value or distribution instead of what is drawn for every flight, e.g. "
        "'wind.speed={uniform: [0, 5]}' or mission.duration=120; may be repeated",
    )
    places = parser.add_mutually_exclusive_group()
    places.add_argument(
        "--workers", type=number(int, 1), metavar="N", help="processes (default: one for each core)"
    )
    places.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="fly on a Dask cluster instead, e.g. tcp://host:8786 (needs the extra [dask])",
    )
    add_output_arguments(
        parser,
        "flights.parquet, campaign.json, campaign.html and the worst flights "
        "(default: output/campaigns/NAME)",
        page="the tables",
    )


def run(arguments: argparse.Namespace) -> int:
    """Fly the campaign.

    Args:
        arguments: As parsed.

    Returns:
        Exit code.
    """
    from uav_tracking_mpc.studies.campaign.campaign_file import load_campaign
    from uav_tracking_mpc.studies.campaign.campaign_results import campaign_study
    from uav_tracking_mpc.studies.campaign.campaign_run import run_campaign
    from uav_tracking_mpc.studies.executors import DaskExecutor, Executor, LocalExecutor

    campaign = load_campaign(
        arguments.campaign,
        tuple(arguments.overrides),
        tuple(arguments.laws or ()),
        arguments.flights,
    )
    executor: Executor = (
        LocalExecutor(arguments.workers)
        if arguments.scheduler is None
        else DaskExecutor(arguments.scheduler)
    )
    arguments.output = arguments.output or Path("output") / "campaigns" / campaign.name
    check_writable(arguments.output)
    with closing(executor):
        results = run_campaign(campaign, executor, arguments.output)
    return publish(campaign_study(results), arguments)
