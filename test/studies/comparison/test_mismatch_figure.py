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
from compared_flights import mistold
from matplotlib.markers import CARETLEFT

from uav_tracking_mpc.report.figure_style import LAWS, png
from uav_tracking_mpc.studies.comparison.mismatch_figure import mismatch_figure


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
    assert list(bank_rates.lines[-1].get_xdata()) == pytest.approx([1.5 * better] * 2)
    assert len(png(figure)) < 300_000


def test_what_the_axis_cannot_show_points_beyond_it():
    mismatch = mistold()
    fine = dataclasses.replace(mismatch.measures["nmpc"], range_rms_m=2e-4)
    mismatch = dataclasses.replace(mismatch, measures={**mismatch.measures, "nmpc": fine})
    figure = mismatch_figure([mismatch])
    own, other, *_ = figure.axes[0].lines
    assert own.get_marker() == CARETLEFT
    assert other.get_marker() != CARETLEFT
    assert "below 0.001 m or 0.1 deg/s" in [w.get_text() for w in figure.legends[0].get_texts()]
