"""One folder that tells the comparison: ``compare.json``, pictures, a page that needs no other."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.studies.comparison.comparison_figures import scenario_figure, summary_figure
from uav_tracking_mpc.studies.comparison.comparison_table import COLUMNS, caption, misses, rows
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
    text = json.dumps(numbers, indent=2, allow_nan=False) + "\n"
    write_atomically(output / "compare.json", text.encode())
    summary = png(summary_figure(scenarios))
    write_atomically(output / "summary.png", summary)
    pictures = {each.name: png(scenario_figure(each)) for each in scenarios}
    for name, picture in pictures.items():
        write_atomically(output / f"{name}.png", picture)
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = (
        resources.files("uav_tracking_mpc.studies.comparison").joinpath(TEMPLATE).read_text("utf-8")
    )
    page = environment.from_string(source).render(
        config=numbers["config"],
        columns=COLUMNS,
        scenarios=scenarios,
        rows=rows(scenarios),
        misses=misses(scenarios),
        caption=caption(),
        summary=_embedded(summary),
        pictures={name: _embedded(picture) for name, picture in pictures.items()},
    )
    write_atomically(output / "compare.html", page.encode())


def _embedded(picture: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(picture).decode()
