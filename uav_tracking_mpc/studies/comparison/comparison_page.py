"""One folder that tells the comparison: ``compare.json``, pictures, a page that needs no other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.figure_style import save_figure
from uav_tracking_mpc.report.html_page import embedded, render
from uav_tracking_mpc.studies.comparison.comparison_figures import scenario_figure, summary_figure
from uav_tracking_mpc.studies.comparison.comparison_table import (
    CAPTION,
    COLUMNS,
    comparison_rows,
    misses,
)
from uav_tracking_mpc.studies.comparison.results import Scenario

TEMPLATE = "comparison.html.j2"


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
    summary = save_figure(summary_figure(scenarios), output / "summary.png")
    pictures = {
        each.name: embedded(save_figure(scenario_figure(each), output / f"{each.name}.png"))
        for each in scenarios
    }
    page = render(
        "uav_tracking_mpc.studies.comparison",
        TEMPLATE,
        {},
        config=numbers["config"],
        columns=COLUMNS,
        scenarios=scenarios,
        rows=comparison_rows(scenarios),
        misses=misses(scenarios),
        caption=CAPTION,
        summary=embedded(summary),
        pictures=pictures,
    )
    write_atomically(output / "compare.html", page.encode())
