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

"""All that is computed of one configuration: analysis, the paper's numbers, campaigns, maps."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.figure_style import save_figure
from uav_tracking_mpc.studies.stability import analysis_text, paper_report, paper_report_text
from uav_tracking_mpc.studies.stability.analysis import Analysis, analyse
from uav_tracking_mpc.studies.stability.attraction import (
    AttractionMap,
    attraction_map,
    default_slices,
    save_maps,
)
from uav_tracking_mpc.studies.stability.ellipsoid_campaign import fly_local, fly_nmpc, random_states
from uav_tracking_mpc.studies.stability.stability_figures import (
    decrease_figure,
    ellipsoid_figure,
    maps_figure,
)
from uav_tracking_mpc.terminal.certificate import certificate
from uav_tracking_mpc.terminal.cover import BOXES
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

HORIZONS = (10, 20, 30)  # of the maps


@dataclass(frozen=True)
class StabilityStudy:
    """What was found.

    Attributes:
        analysis: Section 5 of the paper for the configuration.
        rows: The paper's numbers beside the truth.
        content: All of it for programs: plain values.
        certificate: Of the terminal set, None where none was proved.
        maps: Of the domain of attraction, as many as were asked for.
    """

    analysis: Analysis
    rows: tuple[paper_report.Row, ...]
    content: dict[str, Any]
    certificate: dict[str, Any] | None
    maps: list[AttractionMap]

    def save(self, output: Path, figures: bool) -> None:
        """Write ``stability.json``, ``certificate.json``, and what else there is.

        Args:
            output: Folder; it exists.
            figures: Also draw the ellipsoid and the decrease on it.
        """
        write_json(output / "stability.json", self.content)
        if self.certificate is not None:
            write_json(output / "certificate.json", self.certificate)
        if self.maps:
            archive = io.BytesIO()
            save_maps(self.maps, archive)
            write_atomically(output / "attraction.npz", archive.getvalue())
            save_figure(maps_figure(self.maps), output / "attraction.png")
        if figures and self.analysis.certified:
            self._draw(output)

    def _draw(self, output: Path) -> None:
        problem, varrho = self.analysis.problem, self.content["varrho"]
        picture = ellipsoid_figure(problem, varrho["certified"])
        save_figure(picture, output / "ellipsoid.png")
        marks = {
            "Theorem 3, proved": varrho["theorem3"],
            "U allows, certified": varrho["certified"],
            "decrease, proved": varrho["decrease"],
        }
        ceiling = min(1.15 * max(marks.values()), 0.999 * varrho["domain"])
        save_figure(decrease_figure(problem, marks, ceiling), output / "decrease.png")


def stability_study(
    problem: StabilityProblem,
    *,
    boxes: int = BOXES,
    campaign: int = 0,
    points: int = 0,
    workers: int | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> StabilityStudy:
    """Analyse a configuration, and fly it where a terminal set is certified.

    Args:
        problem: The configuration.
        boxes: Budget of each proof.
        campaign: Random states to fly; 0 for none.
        points: Of the maps along each coordinate; 0 for no maps.
        workers: Processes for maps and campaign; all cores by default.
        say: Told in words what is being done.
    """
    analysis = analyse(problem, say, boxes)
    say("the paper, quantity by quantity")
    rows = paper_report.paper_report()
    content = {
        **analysis_text.as_json(analysis),
        "paper_as_printed": paper_report.paper_as_printed(),
        "paper_report": [asdict(row) for row in rows],
    }
    written, maps = None, []
    if analysis.direct is not None and analysis.certified:
        written = certificate(problem, analysis.ingredients, analysis.direct)
        content["certificate_digest"] = written["digest"]
        if campaign:
            content["campaign"] = _campaign(problem, analysis.level, campaign, workers)
        if points:
            maps = [
                attraction_map(problem, analysis.level, where, horizon, workers)
                for where in default_slices(problem, points)
                for horizon in HORIZONS
            ]
            content["maps"] = [_in_numbers(found) for found in maps]
    return StabilityStudy(analysis, rows, content, written, maps)


def _campaign(
    problem: StabilityProblem, level: float, count: int, workers: int | None
) -> list[dict[str, Any]]:
    states = random_states(problem, level, count)
    results = (fly_local(problem, level, states), fly_nmpc(problem, level, states, workers=workers))
    return [{**asdict(result), "clean": result.clean} for result in results]


def _in_numbers(found: AttractionMap) -> dict[str, Any]:
    return {
        "coordinates": [found.slice.first, found.slice.second],
        "horizon": found.horizon,
        "feasible_share": float(found.feasible.mean()),
        "marked_state": found.marked.tolist(),
        "marked_feasible": found.marked_feasible,
    }


def in_words(study: StabilityStudy) -> list[Any]:
    """The study for people: lines of text and a table of rich.

    Args:
        study: What was found.
    """
    return [
        paper_report_text.numbers_table(study.rows).as_rich(),
        *paper_report_text.verdicts(study.rows),
        analysis_text.as_words(study.analysis),
        *(f"  campaign {entry}" for entry in study.content.get("campaign", [])),
        *(f"  map {entry}" for entry in study.content.get("maps", [])),
    ]
