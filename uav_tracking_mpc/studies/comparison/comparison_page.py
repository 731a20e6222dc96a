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

"""One folder that tells the comparison: the numbers, pictures, a page that needs no other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.figure_style import save_figure
from uav_tracking_mpc.report.html_page import embedded, render
from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.comparison_figures import scenario_figure, summary_figure
from uav_tracking_mpc.studies.comparison.comparison_table import comparison_table, misses
from uav_tracking_mpc.studies.comparison.mismatch_figure import mismatch_figure
from uav_tracking_mpc.studies.comparison.mismatch_table import mismatch_misses, mismatch_table
from uav_tracking_mpc.studies.comparison.results import Scenario

TEMPLATE = "comparison.html.j2"


@dataclass(frozen=True)
class _Section:
    """A picture of the page, under a heading and a description where it has them."""

    picture: str
    alternative: str
    title: str = ""
    description: str = ""


def write_comparison(numbers: dict[str, Any], scenarios: Sequence[Scenario], output: Path) -> None:
    """Write ``compare.json``, ``summary.png``, ``<scenario>.png`` of each and ``compare.html``.

    Args:
        numbers: Content of ``compare.json``.
        scenarios: What was flown.
        output: Folder, made if it is not there.

    Raises:
        OSError: The folder cannot be made or written to.
    """
    output.mkdir(parents=True, exist_ok=True)
    write_json(output / "compare.json", numbers)
    summary = _Section(
        embedded(save_figure(summary_figure(scenarios), output / "summary.png")),
        "Range RMS, settling time and bank rate of every law in every scenario",
    )
    each = [
        _Section(
            embedded(save_figure(scenario_figure(scenario), output / f"{scenario.name}.png")),
            "Paths about the target, range error and bank",
            scenario.title,
            scenario.description,
        )
        for scenario in scenarios
    ]
    title = f"Guidance laws compared: {numbers['config']}"
    page = _page(title, comparison_table(scenarios), misses(scenarios), [summary, *each])
    write_atomically(output / "compare.html", page.encode())


def write_mismatches(numbers: dict[str, Any], mismatches: Sequence[Scenario], output: Path) -> None:
    """Write ``mismatches.json``, ``mismatches.png`` and ``mismatches.html``.

    Args:
        numbers: Content of ``mismatches.json``.
        mismatches: What was flown.
        output: Folder, made if it is not there.

    Raises:
        OSError: The folder cannot be made or written to.
    """
    output.mkdir(parents=True, exist_ok=True)
    write_json(output / "mismatches.json", numbers)
    picture = _Section(
        embedded(save_figure(mismatch_figure(mismatches), output / "mismatches.png")),
        "Range and bank rate RMS of every law under every mismatch",
    )
    title = f"Guidance laws told wrong: {numbers['config']}"
    page = _page(title, mismatch_table(mismatches), mismatch_misses(mismatches), [picture])
    write_atomically(output / "mismatches.html", page.encode())


def _page(title: str, table: Table, missed: Sequence[str], sections: Sequence[_Section]) -> str:
    return render(
        "uav_tracking_mpc.studies.comparison",
        TEMPLATE,
        {},
        title=title,
        table=table,
        own=PREDICTIVE,
        misses=missed,
        sections=sections,
    )
