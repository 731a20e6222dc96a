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

import pytest
from watched_flight_stand_in import sight

from uav_tracking_mpc.view.panel.timing import POINTS, Timing


def cells(text, row):
    """Numbers of a row of the table."""
    line = next(line for line in text.split("<tr") if f">{row}<" in line)
    return [cell.split("</td>")[0] for cell in line.split('tabular-nums">')[1:]]


def test_now_median_and_p99_of_the_last_minute(panel, flight):
    flight.seen = [sight(-100.0, solve_time=9.0)]  # longer ago than a minute
    flight.seen += [sight(0.1 * k, solve_time=1e-3 * k, latency=5e-3) for k in range(101)]
    shown = panel(Timing)
    now, median, p99 = map(float, cells(shown.show(), "Solve time"))
    assert (now, median) == pytest.approx((100.0, 50.0))
    assert p99 == pytest.approx(99.0)
    assert cells(shown.text, "Latency") == ["5.00"] * 3


def test_what_is_not_measured_is_a_dash(panel, flight):
    flight.seen = [sight(latency=math.nan)]
    assert cells(panel(Timing).show(), "Latency") == ["–"] * 3  # noqa: RUF001


def test_points_are_bounded(panel, flight):
    flight.seen = [sight(0.001 * k) for k in range(2 * POINTS)]
    shown = panel(Timing)
    shown.show()
    assert len(shown.part._points) == POINTS
