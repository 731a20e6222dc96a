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

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics import relative
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import (
    rates_function,
    relative_state,
    steady_inputs,
    tracking_error,
    vehicle_state,
)
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL
from uav_tracking_mpc.dynamics.relative_models.kinematics import Exact
from uav_tracking_mpc.dynamics.vehicle import advance

RELATIVE = st.tuples(
    st.floats(60, 400),
    st.floats(-3.1, 3.1),
    st.floats(-40, 40),
    st.floats(-0.6, 0.6),
    st.floats(0.0, 8.0),
)


def test_steady_turn_of_each_model(orbit):
    """Three different turns follow from the slip in (6), (7)."""
    turn = {model: steady_inputs(model, orbit)[0] for model in RELATIVE_MODEL.names}
    assert turn["exact"] == pytest.approx(-4.0 / np.sqrt(150.0**2 - 50.0**2))
    assert turn["paper9"] == pytest.approx(-4.0 * 150.0 / (150.0**2 - 50.0**2))
    assert turn["paper"] == pytest.approx(-4.0 / 150.0)


@pytest.mark.parametrize("direction", ["clockwise", "counter_clockwise"])
@pytest.mark.parametrize("model", RELATIVE_MODEL.names)
def test_both_directions_are_equilibria(model, direction):
    orbit = Orbit(150.0, 50.0, 4.0, direction)
    rates = rates_function(model)(orbit.steady_state, steady_inputs(model, orbit))
    np.testing.assert_allclose(np.array(rates).ravel(), 0.0, atol=1e-14)
    assert np.sign(steady_inputs(model, orbit)[0]) == (-1 if direction == "clockwise" else 1)


class Sluggish(Exact):
    """Turns less than it is told."""

    name = "sluggish"

    def rates(self, state, inputs):
        found = super().rates(state, inputs)
        found[1] = found[1] - 0.1 * inputs[0]
        return found


def test_a_model_that_the_steady_turn_does_not_hold_on_the_orbit_is_refused(orbit):
    with pytest.raises(ValueError, match=r"turn rate of -0\.028.* hold the orbit of 150 m"):
        steady_inputs(f"{__name__}:Sluggish", orbit)


def test_in_flight_a_steady_turn_builds_no_expression(orbit, monkeypatch):
    """Other threads may build some meanwhile, and would have to be waited for."""
    expected = steady_inputs("exact", orbit)
    monkeypatch.setattr(relative, "rates_function", None)
    monkeypatch.setattr(Exact, "rates", None)
    assert steady_inputs("exact", orbit) == pytest.approx(expected)


def test_relative_model_and_vehicle_agree_along_random_flights():
    """The same flights in relative and in Cartesian coordinates, to 1e-9."""
    rates = rates_function("exact")
    random = np.random.default_rng(1)
    for _ in range(12):
        relative = np.array([*random.uniform([120, -3, -40, -0.3, 3], [300, 3, 40, 0.3, 8])])
        target = random.uniform(-50, 50, 3)
        vehicle = vehicle_state(relative, random.uniform(-3, 3), target)
        for _ in range(8):
            inputs = random.uniform([-0.3, -0.1, -0.5], [0.3, 0.1, 0.5])
            vehicle = advance(vehicle, inputs, 0.7)
            relative = solve_ivp(
                lambda t, s, u=inputs: np.array(rates(s, u)).ravel(),
                (0.0, 0.7),
                relative,
                method="DOP853",
                rtol=1e-13,
                atol=1e-12,
            ).y[:, -1]
        seen = relative_state(vehicle, target)
        seen[1] += 2 * np.pi * np.round((relative[1] - seen[1]) / (2 * np.pi))
        np.testing.assert_allclose(seen, relative, rtol=0, atol=1e-9)


def test_paper_model_is_11_as_printed(orbit):
    """(11a)-(11c) with T_s = 1, written out independently."""
    x1, x2, x4, x5 = 30.0, 0.3, 0.2, 1.5
    state = orbit.steady_state + np.array([x1, x2, 7.0, x4, x5])
    rates = np.array(rates_function("paper")(state, [0.0, 0.0, 0.0])).ravel()
    v = x5 + 4.0
    assert rates[0] == pytest.approx(v * (np.sin(x4) ** 2 + np.sin(x2) * np.cos(x4) ** 2))
    printed = v * np.cos(x4) ** 2 * np.cos(x2) / ((x1 + 150.0) * (1 - np.sin(x4) ** 2))
    assert rates[1] == pytest.approx(printed)
    assert rates[2] == pytest.approx(v * np.sin(x4))


def test_paper9_model_is_9_as_printed():
    r, theta, z, chi, v = 180.0, 1.1, 35.0, 0.2, 5.0
    rates = np.array(rates_function("paper9")([r, theta, z, chi, v], [0.1, 0.0, 0.0])).ravel()
    assert rates[0] == pytest.approx(v * (np.sin(chi) ** 2 - np.cos(theta) * np.cos(chi) ** 2))
    printed = v * r * np.cos(chi) ** 2 * np.sin(theta) / (r**2 - z**2) + 0.1
    assert rates[1] == pytest.approx(printed)


@given(RELATIVE, st.floats(-3.1, 3.1), st.tuples(*[st.floats(-100, 100)] * 3))
def test_vehicle_state_is_the_inverse_of_relative_state(relative, azimuth, target):
    assume(relative[0] > abs(relative[2]) + 1.0)
    back = relative_state(vehicle_state(relative, azimuth, target), target)
    np.testing.assert_allclose(back, relative, atol=1e-9)


@given(RELATIVE)
def test_models_coincide_where_the_slip_vanishes(relative):
    """d/r = cos(chi) and z/r = sin(chi): the path angle is the target's elevation."""
    r, theta, _, chi, v = relative
    state = [r, theta, r * np.sin(chi), chi, v]
    exact, paper9 = (
        np.array(rates_function(model)(state, np.zeros(3))).ravel() for model in ("exact", "paper9")
    )
    np.testing.assert_allclose(exact, paper9, atol=1e-12)


def test_unknown_model_is_named():
    with pytest.raises(ValueError, match="'euler', must be one of exact, paper, paper9"):
        rates_function("euler")


def test_point_below_the_ground_of_its_own_range_is_refused():
    with pytest.raises(ValueError, match="at least"):
        vehicle_state([10.0, 0.0, 20.0, 0.0, 4.0], 0.0, np.zeros(3))


def test_bearing_error_is_wrapped(orbit):
    error = tracking_error([150.0, -3.0, 50.0, 0.0, 4.0], orbit)
    assert error[1] == pytest.approx(2 * np.pi - 3.0 - np.pi / 2)
