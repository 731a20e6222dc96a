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

from uav_tracking_mpc.control.command_shaping import FADE_TIME, CommandShaper
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.fallback import FallbackMode

FLIGHT = small_uav.parameters()
PLAN = np.tile([0.1, 0.05, 0.3], (5, 1))
LAW = np.array([[-0.1, 0.0, -0.2]])


@pytest.fixture
def shaper():
    return CommandShaper(FLIGHT, EventLog())


def test_inputs_are_kept_inside_limits_that_the_airspeed_decides(shaper):
    wild = np.array([[9.0, -9.0, 99.0], [np.nan, np.inf, -np.inf]])
    shaped = shaper.shape(0.0, wild, 1.0, 25.0, FallbackMode.OPTIMAL)
    turn = FLIGHT.envelope.turn_rate_max(25.0)
    np.testing.assert_array_equal(
        shaped[0], [turn, -FLIGHT.pitch_rate_max, FLIGHT.acceleration_max]
    )
    np.testing.assert_array_equal(shaped[1], 0.0)


def test_plans_follow_each_other_as_they_are(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    for mode in (FallbackMode.EARLIER_PLAN, FallbackMode.FEASIBLE, FallbackMode.OPTIMAL):
        np.testing.assert_array_equal(shaper.shape(0.1, -PLAN, 0.5, 22.0, mode), -PLAN)


def test_a_law_takes_over_from_a_plan_little_by_little(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    for time in (0.0, 0.1, 0.5, 9.0):
        (shaped,) = shaper.shape(time, LAW, 1.0, 22.0, FallbackMode.LOITER)
        share = np.exp(-time / FADE_TIME)
        np.testing.assert_allclose(shaped, share * PLAN[0] + (1.0 - share) * LAW[0], atol=1e-12)


def test_within_a_plan_the_fading_goes_on(shaper):
    shaper.shape(0.0, LAW, 1.0, 22.0, FallbackMode.LOITER)
    shaped = shaper.shape(0.1, PLAN, 0.25, 22.0, FallbackMode.OPTIMAL)
    share = np.exp(-0.25 * np.arange(5) / FADE_TIME)[:, np.newaxis]
    np.testing.assert_allclose(shaped, PLAN + share * (LAW - PLAN), atol=1e-12)


def test_other_parameters_take_over_without_a_jump(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    shaper.change(replace(FLIGHT, acceleration_max=1.0))
    shaped = shaper.shape(0.1, -PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    np.testing.assert_allclose(shaped[0], PLAN[0], atol=1e-12)


def test_a_change_with_every_command_makes_it_lag_and_never_stops_it(shaper):
    """The turn rate that is wanted rises by 0.1 rad/s in a second, at 20 Hz."""
    for count in range(61):
        wanted = np.array([[0.005 * count - 0.1, 0.0, 0.0]])
        shaper.change(FLIGHT)
        (shaped,) = shaper.shape(0.05 * count, wanted, 1.0, 22.0, FallbackMode.OPTIMAL)
    lag = wanted[0] - shaped
    np.testing.assert_allclose(lag, [0.1 * FADE_TIME, 0.0, 0.0], rtol=0.15)


def test_two_guidances_that_alternate_are_blended(shaper):
    sent = []
    for count in range(100):
        inputs, mode = [(PLAN, FallbackMode.OPTIMAL), (LAW, FallbackMode.LOITER)][count % 2]
        sent.append(shaper.shape(0.05 * count, inputs, 1.0, 22.0, mode)[0])
    middle = 0.5 * (PLAN[0] + LAW[0])
    np.testing.assert_allclose(sent[-2:], [middle, middle], atol=0.1 * np.max(PLAN[0] - LAW[0]))


def test_after_silence_the_command_comes_as_it_is(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    shaper.reset()
    np.testing.assert_array_equal(shaper.shape(0.1, LAW, 1.0, 22.0, FallbackMode.LOITER), LAW)
