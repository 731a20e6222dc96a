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

"""An autopilot that holds altitude and airspeed by its energy."""

import math

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.dynamics.energy_hold import HoldConstants, hold, saturated

ARDUPLANE = HoldConstants(5.0, 1.0, 5.0, 5.0, 4.0, 2.0)


def test_small_errors_go_over_their_time_constants() -> None:
    climb, gain = hold(0.1, 0.0, 0.0, 20.0, 0.02, ARDUPLANE, math)
    assert climb == pytest.approx(0.1 / 5.0 / 1.0 / 20.0, rel=1e-6)
    assert gain == pytest.approx(0.02 / 5.0, rel=1e-6)


def test_what_is_held_is_at_rest_in_rising_air() -> None:
    path_angle = -math.asin(1.5 / 20.0)  # which takes a rising of the air by 1.5 m/s out
    climb_rate = 20.0 * math.sin(path_angle) + 1.5
    np.testing.assert_allclose(
        hold(0.0, climb_rate, path_angle, 20.0, 0.0, ARDUPLANE, math), 0.0, atol=1e-12
    )


@pytest.mark.parametrize(("error", "limit"), [(1e4, 5.0), (-1e4, -4.0)])
def test_climb_and_sink_rates_are_limited(error: float, limit: float) -> None:
    climb, _ = hold(error, limit, 0.0, 20.0, 0.0, ARDUPLANE, math)
    assert climb == pytest.approx(0.0, abs=1e-6)


def test_half_of_the_energy_rate_goes_into_speed() -> None:
    _, most = hold(0.0, 0.0, 0.0, 20.0, 1e4, ARDUPLANE, math)
    _, least = hold(0.0, 0.0, 0.0, 20.0, -1e4, ARDUPLANE, math)
    assert most == pytest.approx(0.5 * 9.80665 * 5.0 / 20.0)
    assert least == pytest.approx(-0.5 * 9.80665 * 2.0 / 20.0)


def test_altitude_and_airspeed_come_back_without_overshoot_worth_mention() -> None:
    height, path_angle, airspeed, step = -30.0, 0.0, 18.0, 0.01
    heights = []
    for _ in range(6000):
        climb_rate = airspeed * math.sin(path_angle)
        u_chi, u_v = hold(
            -height, climb_rate, path_angle, airspeed, 22.0 - airspeed, ARDUPLANE, math
        )
        height += step * climb_rate
        path_angle, airspeed = path_angle + step * u_chi, airspeed + step * u_v
        heights.append(height)
    assert (height, path_angle, airspeed) == pytest.approx((0.0, 0.0, 22.0), abs=0.01)
    assert max(heights) < 0.5


def test_numbers_arrays_and_symbols_agree() -> None:
    values = np.random.default_rng(1).normal(size=(50, 5)) * [20.0, 2.0, 0.2, 3.0, 2.0]
    values[:, 3] += 20.0
    arrays = np.array(hold(*values.T, ARDUPLANE, np))
    symbols = [ca.SX.sym(name) for name in ("h", "w", "chi", "v", "e")]
    function = ca.Function("hold", symbols, hold(*symbols, ARDUPLANE, ca))
    for k, row in enumerate(values.tolist()):
        np.testing.assert_allclose(hold(*row, ARDUPLANE, math), arrays[:, k], rtol=1e-12)
        symbolic = [float(value) for value in function(*row)]
        np.testing.assert_allclose(symbolic, arrays[:, k], rtol=1e-12)


@pytest.mark.parametrize("value", [-1e3, -2.0, -1e-3, 1e-3, 3.0, 1e3])
def test_saturation_stays_between_its_ends(value: float) -> None:
    limited = saturated(value, 2.0, 3.0, math)
    assert -2.0 <= limited <= 3.0
    assert abs(limited) <= abs(value)
