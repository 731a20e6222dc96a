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

import pytest
from compared_flights import compared

from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.studies.comparison.comparison_figures import scenario_figure, summary_figure


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


def test_a_bar_that_the_axis_cannot_show_is_a_bound_in_words():
    still = compared("still")
    fine = dataclasses.replace(still.measures["nmpc"], range_rms_m=2e-4)
    ranges = summary_figure([dataclasses.replace(still, measures={"nmpc": fine})]).axes[0]
    assert [text.get_text() for text in ranges.texts] == ["< 0.001"]
    assert len(ranges.patches) == 0


def test_the_summary_has_a_bar_for_every_flight_that_settled():
    scenarios = [compared("still"), compared("gusts")]
    panels = summary_figure(scenarios).axes
    assert [len(panel.patches) for panel in panels] == [4, 0, 4]
    assert sum(text.get_text() == "never" for text in panels[1].texts) == 4
    assert png(summary_figure(scenarios[:1]))
