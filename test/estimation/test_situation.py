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

from dataclasses import replace

import numpy as np
import pytest
import small_uav
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, DIRECTIONS
from uav_tracking_mpc.dynamics.relative import relative_state, tracking_error
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import (
    FADE_TIME,
    KNOWN,
    Situation,
    outlook,
    steady_forecast,
)
from uav_tracking_mpc.estimation.target_track import REWIND, TURN

FLIGHT = small_uav.parameters()


def test_relative_velocity_is_the_rate_of_the_offset():
    """Finite difference over a steady wind and a target that moves straight."""
    vehicle = np.array([120.0, -40.0, 80.0, 0.7, 0.1, 22.0])
    target, run, wind = np.array([[10.0, 5.0, 2.0], [4.0, 1.0, 0.0], [3.0, -7.0, 0.5]])
    inputs, h = np.array([0.2, 0.05, 0.3]), 1e-4

    def offset(time):
        moved = advance(vehicle, inputs, time)
        moved[:3] += wind * time
        still = np.zeros(3)
        return Situation(moved, target + run * time, wind - run, still, inputs).offset

    now = Situation(vehicle, target, wind - run, np.zeros(3), inputs)
    rate = (offset(h) - offset(-h)) / (2 * h)
    np.testing.assert_allclose(now.relative_velocity, rate, atol=1e-6)
    np.testing.assert_allclose(now.offset, vehicle[:3] - target)
    np.testing.assert_allclose(np.linalg.norm(now.air_velocity), 22.0)


@pytest.mark.parametrize("direction", DIRECTIONS)
@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_without_drift_the_error_is_the_papers(direction, shares):
    orbit = replace(FLIGHT.orbit, direction=direction)
    now = small_uav.situation(
        *np.array([300.0, 300.0, 100.0, 3.0, 0.2, 5.0]) * shares
        + [0.0, 0.0, 120.0, 0.0, 0.0, 22.0],
        target=(50.0, -20.0, 3.0),
    )
    expected = tracking_error(relative_state(now.vehicle, now.target), orbit)
    error = now.tracking_error(orbit)
    difference = error - expected
    difference[1] = np.sin(difference[1])  # half turns may differ in sign
    np.testing.assert_allclose(difference, 0.0, atol=1e-9)


def test_in_a_drift_the_bearing_is_that_of_the_relative_velocity():
    """Crabbing: the nose 25 degrees off the circle, the motion along it."""
    air = np.array([-9.0, 20.0])
    radius = FLIGHT.orbit.radius
    now = small_uav.situation(
        radius, 0.0, 120.0, np.arctan2(*air[::-1]), 0.0, np.hypot(*air), drift=(9.0, 1.0, 0.0)
    )
    orbit = replace(FLIGHT.orbit, direction=COUNTER_CLOCKWISE, speed=float(np.hypot(*air)))
    np.testing.assert_allclose(now.tracking_error(orbit), 0.0, atol=1e-9)


def test_a_steady_forecast_is_the_present_at_every_stage():
    target, drift = np.array([3.0, -4.0, 1.0]), np.array([5.0, 2.0, -0.5])
    now = Situation(np.zeros(6), target, drift, np.array([0.3, 0.0, 0.0]), np.zeros(3))
    forecast = steady_forecast(now, 7)
    np.testing.assert_array_equal(forecast.target, [target] * 8)
    np.testing.assert_array_equal(forecast.drift, [drift] * 8)
    np.testing.assert_array_equal(forecast.drift_rate, np.zeros((8, 3)))


# The outlook, against the formulas evaluated one by one
STATE = np.array([[10.0, -20.0, 3.0], [6.0, -2.0, 0.4], [0.8, 0.3, 0.0]])
WIND, GUST, TIMES = np.array([5.0, 2.0, 0.1]), np.array([1.0, -2.0, 0.5]), np.array([8.0, 8.0, 3.0])
TREND = np.array([0.1, -0.2, 0.0])
FADED = np.array([1.0, -0.5, 0.2, 0.3, 0.1, -0.1])
AHEAD = np.array([0.0, 0.2, 0.5, 3.0, 10.0])


def ahead(travelled=0.3, left=1.0, faded=FADED, turn_rate=0.2):
    known = np.concatenate(
        [STATE.ravel(), [0.04, turn_rate, travelled, left], faded, WIND, TREND, GUST, TIMES]
    )
    assert known.shape == (KNOWN.size,)
    return outlook(len(AHEAD))(known, AHEAD).full().T.reshape(-1, 3, 3).swapaxes(0, 1)


@pytest.mark.parametrize(("travelled", "left"), [(0.3, 1.0), (6.0, 0.5), (0.0, 0.0)])
@pytest.mark.parametrize("turn_rate", [0.0, 0.2, -2.0])
def test_target_wind_gust_and_what_fades_add_up(travelled, left, turn_rate):
    target, drift, drift_rate = ahead(travelled, left, turn_rate=turn_rate)
    leads = travelled + left * AHEAD
    motions = [TURN(STATE.ravel(), 0.04, turn_rate, lead).full().reshape(3, 3) for lead in leads]
    p, v, a = np.swapaxes(motions, 0, 1)
    share = np.exp(-AHEAD / FADE_TIME)[:, np.newaxis]
    gust = np.exp(-AHEAD[:, np.newaxis] / TIMES) * GUST
    np.testing.assert_allclose(target, p + share * FADED[:3], atol=1e-9)
    expected = WIND + AHEAD[:, np.newaxis] * TREND + gust - left * v - share * FADED[3:]
    np.testing.assert_allclose(drift, expected, atol=1e-9)
    np.testing.assert_allclose(drift_rate, TREND - gust / TIMES - left**2 * a, atol=1e-9)


def test_a_track_is_not_followed_further_back_than_it_reaches():
    back = ahead(travelled=-5.0, left=0.0, faded=np.zeros(6))
    least = TURN(STATE.ravel(), 0.04, 0.2, -REWIND).full()[:3].ravel()
    np.testing.assert_allclose(back[0], np.tile(least, (len(AHEAD), 1)), atol=1e-9)
