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

"""One folder that tells the campaign: results, a page, the worst flights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.figure_style import save_figure
from uav_tracking_mpc.report.html_page import embedded, render
from uav_tracking_mpc.studies.campaign.campaign_figure import campaign_figure
from uav_tracking_mpc.studies.campaign.campaign_results import replay_file, worst_flights
from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults
from uav_tracking_mpc.studies.campaign.campaign_tables import (
    failure_table,
    quantile_table,
    trait_table,
    worst_table,
)
from uav_tracking_mpc.studies.campaign.flight_plan import planned

TEMPLATE = "campaign.html.j2"


def write_campaign(numbers: dict[str, Any], results: CampaignResults) -> None:
    """Write ``campaign.json``, ``campaign.png``, ``campaign.html`` and ``worst/*.yaml``.

    Args:
        numbers: Content of ``campaign.json``.
        results: Of the flights; the files go where theirs is.

    Raises:
        OSError: The folder cannot be written to.
    """
    folder, campaign = results.file.parent, results.campaign
    (folder / "worst").mkdir(exist_ok=True)
    for old in (folder / "worst").glob("flight_*.yaml"):
        old.unlink()
    for row in worst_flights(results):
        configuration = planned(campaign, row["flight"]).configuration(campaign.laws[0])
        write_atomically(Path(replay_file(results, row)), configuration.yaml().encode())
    write_json(folder / "campaign.json", numbers)
    picture = save_figure(campaign_figure(results), folder / "campaign.png")
    page = render(
        "uav_tracking_mpc.studies.campaign",
        TEMPLATE,
        {},
        title=campaign.title or campaign.name,
        description=campaign.description,
        picture=embedded(picture),
        tables=tables(results),
    )
    write_atomically(folder / "campaign.html", page.encode())


def tables(results: CampaignResults) -> dict[str, Any]:
    """All tables of a campaign, by what they show.

    Args:
        results: Of the flights.
    """
    found = {
        "Failures": failure_table(results),
        "Quantiles": quantile_table(results),
        "What they have in common": trait_table(results),
        "The worst flights": worst_table(results),
    }
    return {title: table for title, table in found.items() if table.rows}


def write_into(page: Path, results: CampaignResults) -> None:
    """Put the tables into a page of the documentation, where it has a place for them.

    Args:
        page: File of the page, with ``<!-- table NAME -->`` for some of ``failures``,
            ``quantiles``, ``traits`` and ``worst``.
        results: Of the flights.

    Raises:
        ValueError: The page has no such place.
    """
    makers = {
        "failures": failure_table,
        "quantiles": quantile_table,
        "traits": trait_table,
        "worst": worst_table,
    }
    for name, table in makers.items():
        table(results).write_into(page, name)
