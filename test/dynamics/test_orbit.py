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


import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics.orbit import (
    COUNTER_CLOCKWISE,
    DIRECTIONS,
    Orbit,
    orbit_about,
    orbit_motion,
)
from uav_tracking_mpc.dynamics.relative import steady_inputs


def test_radius_is_the_horizontal_distance_and_direction_chooses_the_bearing(orbit):
    assert orbit.radius == pytest.approx(np.sqrt(150.0**2 - 50.0**2))
    assert orbit.steady_state == pytest.approx([150.0, np.pi / 2, 50.0, 0.0, 4.0])
    assert Orbit(150.0, 50.0, 4.0, "counter_clockwise").bearing == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ((50.0, 50.0, 4.0), "range is 50.0"),
        ((40.0, -50.0, 4.0), "range is 40.0"),
        ((np.nan, 50.0, 4.0), "range is nan"),
        ((150.0, np.inf, 4.0), "altitude is inf"),
        ((150.0, 50.0, 0.0), "speed is 0.0"),
        ((150.0, 50.0, 4.0, "left"), "direction is 'left'"),
    ],
)
def test_what_is_no_orbit_is_refused_by_name_and_value(values, name):
    with pytest.raises(ValueError, match=name):
        Orbit(*values)


RADIUS, AIRSPEED = 275.0, 22.0


def _motion_function():
    phi, sense, radius, airspeed = (ca.SX.sym(name) for name in ("phi", "sigma", "d", "v"))
    drift, rate = ca.SX.sym("c", 3), ca.SX.sym("c'", 3)
    motion = orbit_motion((ca.cos(phi), ca.sin(phi)), sense, radius, airspeed, drift, rate)
    return ca.Function(
        "motion",
        [phi, sense, radius, airspeed, drift, rate],
        [
            ca.vertcat(*motion.tangent),
            motion.relative_speed,
            motion.turn_rate,
            motion.turn_acceleration,
            motion.path_angle,
        ],
    )


MOTION = _motion_function()


def motion(phi, sense, drift, rate=(0.0, 0.0, 0.0), radius=RADIUS, airspeed=AIRSPEED):
    """Tangent (2,), relative speed, turn rate, its rate, path angle."""
    values = MOTION(phi, sense, radius, airspeed, ca.DM(drift), ca.DM(rate))
    return np.array(values[0]).ravel(), *(float(value) for value in values[1:])


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(
    ("drift", "rate"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((8.0, -5.0, 0.0), (0.0, 0.0, 0.0)),
        ((-12.0, 9.0, 1.5), (0.0, 0.0, 0.0)),  # a lift, flown against with a descent
        ((4.0, 3.0, -1.0), (-0.15, 0.1, 0.0)),  # a target that accelerates
    ],
)
def test_its_turn_rate_keeps_the_flight_on_the_circle(sense, drift, rate):
    """Heading, path angle and airspeed as it says; nothing corrects an error for 60 s."""
    drift, rate = np.array(drift), np.array(rate)
    tangent, speed, _, _, path_angle = motion(0.7, sense, drift, rate)
    air = speed * tangent - drift[:2]
    start = [RADIUS * np.cos(0.7), RADIUS * np.sin(0.7), 0.0, np.arctan2(air[1], air[0])]
    assert np.hypot(*air) == pytest.approx(AIRSPEED * np.cos(path_angle), abs=1e-12)

    def flight(time, state):
        x, y, _, psi = state
        now = drift + rate * time
        phi = np.arctan2(y, x)
        turn = motion(phi, sense, now, rate)[2]
        level = AIRSPEED * np.cos(path_angle)
        climb = AIRSPEED * np.sin(path_angle) + now[2]
        return [level * np.cos(psi) + now[0], level * np.sin(psi) + now[1], climb, turn]

    flown = solve_ivp(flight, (0.0, 60.0), start, rtol=1e-10, atol=1e-10, max_step=1.0).y
    assert np.abs(np.hypot(flown[0], flown[1]) - RADIUS).max() < 1e-6
    assert np.abs(flown[2]).max() < 1e-6
    turned = np.unwrap(np.arctan2(flown[1], flown[0]))
    assert sense * (turned[-1] - turned[0]) > 2.0  # it does go round, the right way


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_without_drift_it_is_the_papers_steady_turn(direction):
    orbit = Orbit(300.0, 120.0, 22.0, direction)
    sense = 1.0 if direction == COUNTER_CLOCKWISE else -1.0
    still = motion(1.9, sense, np.zeros(3), radius=orbit.radius, airspeed=orbit.speed)
    expected = orbit.speed, steady_inputs("exact", orbit)[0], 0.0, 0.0
    np.testing.assert_allclose(still[1:], expected, atol=1e-15)


@given(
    st.floats(-np.pi, np.pi),
    st.sampled_from([1.0, -1.0]),
    st.floats(0.0, 0.85),
    st.floats(-np.pi, np.pi),
    st.floats(-3.0, 3.0),
)
def test_turn_acceleration_is_the_derivative_of_the_turn_rate_along_the_motion(
    phi, sense, share, towards, vertical
):
    """Central difference over the azimuth, times its rate sigma s / d."""
    drift = np.array([*(share * AIRSPEED * np.array([np.cos(towards), np.sin(towards)])), vertical])
    _, speed, _, acceleration, _ = motion(phi, sense, drift)
    h = 1e-4
    slope = (motion(phi + h, sense, drift)[2] - motion(phi - h, sense, drift)[2]) / (2.0 * h)
    assert acceleration == pytest.approx(slope * sense * speed / RADIUS, rel=1e-4, abs=1e-8)


def test_the_sharpest_turn_is_where_the_drift_follows_the_flight():
    """(V + |c|)^2 / (d V): what the envelope refuses orbits by."""
    drift = np.array([9.0, 0.0, 0.0])
    azimuths = np.linspace(-np.pi, np.pi, 721)
    rates = [motion(phi, 1.0, drift)[2] for phi in azimuths]
    sharpest = (AIRSPEED + 9.0) ** 2 / (RADIUS * AIRSPEED)
    assert max(rates) == pytest.approx(sharpest)
    assert azimuths[np.argmax(rates)] == pytest.approx(-np.pi / 2.0)  # tangent along +x


@given(*[st.floats(-1e4, 1e4)] * 3, st.floats(0.1, 400.0))
def test_drifts_that_nothing_can_fly_in_still_give_finite_values(x, y, z, airspeed):
    """Iterates of a solver pass through such places."""
    if abs(z) < airspeed:
        _, *values = motion(0.3, 1.0, (x, y, z), airspeed=airspeed)
        assert np.all(np.isfinite(values))


TARGET, VELOCITY = (10.0, 20.0, 5.0), (1.0, -2.0, 0.5)


@pytest.mark.parametrize(
    ("direction", "shape", "radius", "height", "airspeed"),
    [
        ("clockwise", None, -40.0, 35.0, 12.0),
        ("counter_clockwise", None, 40.0, 35.0, 12.0),
        ("clockwise", np.array([100.0, 60.0, 15.0]), -80.0, 65.0, 15.0),
    ],
)
def test_that_is_the_wanted_one_in_the_map_or_another_shape(
    direction, shape, radius, height, airspeed
):
    flown = orbit_about(TARGET, VELOCITY, Orbit(50.0, 30.0, 12.0, direction), shape)
    np.testing.assert_allclose(flown.centre, [10.0, 20.0, height])
    np.testing.assert_allclose(flown.velocity, VELOCITY)
    assert (flown.radius, flown.airspeed) == pytest.approx((radius, airspeed))
