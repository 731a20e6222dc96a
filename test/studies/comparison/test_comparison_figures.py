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


def test_the_summary_has_a_bar_for_every_flight_that_settled():
    scenarios = [compared("still"), compared("gusts")]
    panels = summary_figure(scenarios).axes
    assert [len(panel.patches) for panel in panels] == [4, 0, 4]
    assert sum(text.get_text() == "never" for text in panels[1].texts) == 4
    assert png(summary_figure(scenarios[:1]))
