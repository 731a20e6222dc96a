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
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering

from uav_tracking_mpc.view.panel.wind import Wind, from_where
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR


@pytest.fixture
def wind(panel, flight):
    flight.steering.values[SIMULATOR]["wind"] = (0.0, -8.0, 0.5)
    shown = panel(Wind)
    shown.until(lambda: "wind [m/s]" in shown.labels())
    return shown


@pytest.mark.parametrize(
    ("blows_to", "speed", "azimuth"),
    [((0.0, -8.0, 0.0), 8.0, 0.0), ((-3.0, 0.0, 0.0), 3.0, 90.0), ((5.0, 5.0, 0.0), 7.071, 225.0)],
)
def test_wind_is_told_by_where_it_comes_from(blows_to, speed, azimuth):
    assert from_where(blows_to) == pytest.approx((speed, azimuth), abs=1e-3)


def test_sliders_stand_at_the_wind(wind):
    assert (wind.widget("wind [m/s]").value, wind.widget("from [deg]").value) == (8.0, 0.0)


def test_speed_and_direction_become_east_and_north(wind, flight):
    wind.by_hand("wind [m/s]", 10.0)
    wind.by_hand("from [deg]", 90.0)
    wind.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", SIMULATOR, {"wind": (-10.0, 0.0, 0.5)})]


def test_without_wind_its_direction_waits_for_some(wind, flight):
    wind.by_hand("from [deg]", 270.0)
    wind.by_hand("wind [m/s]", 0.0)
    wind.until(lambda: flight.steering.values[SIMULATOR]["wind"] == (0.0, 0.0, 0.5))
    wind.until(lambda: "asking" not in wind.text)
    wind.part._touched = float("-inf")  # nobody has touched it for long
    wind.show()
    assert wind.widget("from [deg]").value == 270.0


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_a_number_that_is_not_finite_is_refused_and_the_slider_goes_on(wind, flight, number):
    wind.by_hand("from [deg]", number)
    assert f"from [deg] cannot be {number}" in wind.show()
    assert wind.widget("from [deg]").value == 0.0
    wind.by_hand("from [deg]", 90.0)
    wind.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", SIMULATOR, {"wind": (-8.0, 0.0, 0.5)})]


def test_gusts(wind, flight):
    wind.by_hand("gusts [m/s]", 7.5)
    wind.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", SIMULATOR, {"gust_intensity": 7.5})]


def test_it_is_absent_against_a_real_autopilot():
    flight = StandInFlight(steering=StandInSteering([CONTROLLER]))
    assert not Wind.fits(flight, StandInSource(flight))
