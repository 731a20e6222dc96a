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


import dataclasses
import json

import pytest
from example_flights import compared, mistold
from matplotlib.markers import CARETLEFT

from uav_tracking_mpc.report.figure_style import LAWS, png
from uav_tracking_mpc.studies.comparison.figures import (
    comparison,
    mismatch_figure,
    scenario_figure,
    summary_figure,
)
from uav_tracking_mpc.studies.comparison.results import MISTOLD, SCENARIOS


@pytest.mark.parametrize("name", ["still", "gusts", "circling_target"])
def test_the_picture_of_a_scenario_shows_what_moves(name):
    figure = scenario_figure(compared(name))
    top_view = figure.axes[0]
    words = [text.get_text() for text in top_view.texts if text.get_text()]
    expected = {
        "still": [],
        "gusts": ["wind 5 m/s and gusts"],
        "circling_target": ["wind 5 m/s", "target 5 m/s at the start"],
    }
    assert words == expected[name]
    assert len(png(figure)) < 300_000


def test_the_path_begins_where_the_aircraft_is_seen_from_the_target():
    scenario = compared("circling_target")
    path = scenario_figure(scenario).axes[0].lines[1].get_xydata()
    assert path[0] == pytest.approx([591.608, 0.0], abs=1e-3)


def test_the_words_of_a_picture_have_one_meaning_each():
    """The target is what is circled; a bank is positive with the right wing down."""
    figure = scenario_figure(compared("circling_target"))
    _, error, bank = figure.axes
    assert "asked of nmpc" in error.get_title("left") and "target" not in error.get_title("left")
    assert "right wing down" in bank.get_title("left")
    legend = summary_figure([compared("still")]).legends[0]
    assert [words.get_text() for words in legend.get_texts()] == ["nmpc", "l1", "asked of nmpc"]


def measured(scenario, **measures):
    """The scenario with other measures of its flights."""
    changed = dataclasses.replace(scenario)
    vars(changed)["measures"] = measures
    return changed


def test_a_bar_that_the_axis_cannot_show_is_a_bound_in_words():
    still = compared("still")
    fine = dataclasses.replace(still.measures["nmpc"], range_rms_m=2e-4)
    ranges = summary_figure([measured(still, nmpc=fine)]).axes[0]
    assert [text.get_text() for text in ranges.texts] == ["< 0.001"]
    assert len(ranges.patches) == 0


def test_the_summary_has_a_bar_for_every_flight_that_settled():
    scenarios = [compared("still"), compared("gusts")]
    panels = summary_figure(scenarios).axes
    assert [len(panel.patches) for panel in panels] == [4, 0, 4]
    assert sum(text.get_text() == "never" for text in panels[1].texts) == 4
    assert png(summary_figure(scenarios[:1]))


def test_there_is_a_mark_for_every_flight_and_a_bar_for_what_is_asked():
    mismatches = [mistold(), mistold("gust_light")]
    figure = mismatch_figure(mismatches)
    ranges, bank_rates = figure.axes
    assert [label.get_text() for label in ranges.get_yticklabels()] == ["lag_2", "gust_light"]
    own, other, bar, *_ = ranges.lines
    assert own.get_color() == LAWS["nmpc"]
    assert own.get_xdata()[0] == mismatches[0].measures["nmpc"].range_rms_m
    assert other.get_xdata()[0] == mismatches[0].measures["l1"].range_rms_m
    assert list(bar.get_xdata()) == [0.5, 0.5]
    better = mismatches[1].measures["l1"].bank_rate_rms_dps
    assert list(bank_rates.lines[-1].get_xdata()) == pytest.approx([1.25 * better] * 2)
    assert len(png(figure)) < 300_000


def test_what_the_axis_cannot_show_points_beyond_it():
    mismatch = mistold()
    fine = dataclasses.replace(mismatch.measures["nmpc"], range_rms_m=2e-4)
    mismatch = measured(mismatch, **{**mismatch.measures, "nmpc": fine})
    figure = mismatch_figure([mismatch])
    own, other, *_ = figure.axes[0].lines
    assert own.get_marker() == CARETLEFT
    assert other.get_marker() != CARETLEFT
    assert "below 0.001 m or 0.1 deg/s" in [w.get_text() for w in figure.legends[0].get_texts()]


def test_the_folder_tells_the_comparison(tmp_path):
    study = comparison([compared("still"), compared("gusts")])
    study.publish(tmp_path / "new")
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {"compare.json", "compare.html", "summary.png", "still.png", "gusts.png"}
    assert json.loads((tmp_path / "new" / "compare.json").read_text()) == study.content
    page = (tmp_path / "new" / "compare.html").read_text()
    assert page.count("data:image/png;base64,") == 3
    assert "Wind with gusts" in page
    assert "gusts: within 10 m never" in page
    assert "http" not in page


def test_another_folder_tells_what_happens_where_it_is_told_wrong(tmp_path):
    study = comparison([mistold(), mistold("gust_light")], MISTOLD)
    words = study.publish(tmp_path / "new")
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {"mismatches.json", "mismatches.html", "mismatches.png"}
    assert words[-1] == f"report: {tmp_path / 'new' / 'mismatches.html'}"
    page = (tmp_path / "new" / "mismatches.html").read_text()
    assert page.count("data:image/png;base64,") == 1
    assert "Guidance laws under mismatch: small_uav" in page
    assert "lag_2: range RMS" in page


@pytest.mark.parametrize(("left", "written"), [("", "| gusts | nmpc |"), ("some", "before")])
def test_documentation_changes_only_with_all_that_was_asked_for(tmp_path, left, written):
    page = tmp_path / "page.md"
    page.write_text("<!-- table comparison -->\nbefore\n<!-- end -->\n")
    comparison([compared()], SCENARIOS, left).publish(None, page)
    assert written in page.read_text()
