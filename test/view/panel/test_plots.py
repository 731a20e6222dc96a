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

import math

import numpy as np
import pytest
from watched_flight_stand_in import sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.panel.plots import POINTS, SPAN, Plots


def plots(shown):
    """Range error, bank, cost."""
    return [handle for handle in shown._handles() if hasattr(handle._impl.props, "series")]


def test_the_last_minutes_over_the_time_before_now(panel, flight):
    flight.seen = [sight(k * 1.0, bank=math.radians(k), cost=1.0 + k) for k in range(31)]
    shown = panel(Plots)
    shown.show()
    error, bank, cost = plots(shown)
    assert (bank.data[0][0], bank.data[0][-1]) == (-30.0, 0.0)
    assert bank.data[2] == pytest.approx(np.arange(31.0))
    assert (bank.data[3][0], bank.data[4][0]) == pytest.approx((45.0, -45.0))
    assert cost.data[2][-1] == 31.0
    assert error.data[2][-1] == 0.4


def test_points_are_bounded(panel, flight):
    shown = panel(Plots)
    for begin in range(0, 800, 10):
        flight.seen = [sight(begin + 0.1 * k) for k in range(100)]
        shown.show()
    for plot in plots(shown):
        assert len(plot.data[0]) <= POINTS
        assert plot.data[0].min() >= -SPAN


def test_a_plot_without_a_point_does_not_appear(panel, flight):
    flight.seen = [sight(cost=math.nan)]
    shown = panel(Plots)
    shown.show()
    assert [plot.visible for plot in plots(shown)] == [True, True, False]


def test_what_is_not_finite_is_left_out(panel, flight):
    flight.seen = [sight(1.0), sight(2.0, cost=math.nan), sight(3.0, cost=math.inf), sight(4.0)]
    shown = panel(Plots)
    shown.show()
    assert plots(shown)[2].data[0].tolist() == [-3.0, 0.0]
    assert all(np.isfinite(line).all() for plot in plots(shown) for line in plot.data)


def test_fallback_is_shaded(panel, flight):
    flight.seen = [sight(1.0), sight(2.0, mode=FallbackMode.LOITER), sight(3.0)]
    shown = panel(Plots)
    shown.show()
    assert plots(shown)[0].data[1].tolist() == [0.0, 1.0, 0.0]


def test_time_is_no_date(panel):
    for plot in plots(panel(Plots)):
        assert plot.scales["x"]["time"] is False
