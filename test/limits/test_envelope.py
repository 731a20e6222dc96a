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
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.limits import Motion, OrbitShape
from uav_tracking_mpc.limits.airspeed import Acceleration
from uav_tracking_mpc.limits.climb import PathAngle, PitchRate
from uav_tracking_mpc.limits.envelope import Envelope, input_span
from uav_tracking_mpc.limits.turn import Bank, YawRate
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration

VALUES = {
    "airspeed_min": 14.0,
    "airspeed_max": 32.0,
    "path_angle_min": math.radians(-9.0),
    "path_angle_max": math.radians(14.0),
    "bank_max": math.radians(45.0),
    "yaw_rate_max": 0.785,
    "pitch_rate_max": 0.785,
    "acceleration_min": -1.5,
    "acceleration_max": 3.0,
    "force_min": (-1.2, -4.0),
    "force_max": (5.0, 1.0),
}
SMALL_UAV = Envelope(**VALUES)
STILL = np.zeros(3)

finite = st.floats(allow_nan=False, allow_infinity=False)
anything = st.floats()
drifts = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-4, 4)).map(np.array)


@st.composite
def orbits(draw):
    altitude = draw(st.floats(-2e3, 2e3))
    radius = draw(st.floats(1.0, 1e4))
    return Orbit(math.hypot(radius, altitude), altitude, draw(st.floats(0.5, 60.0)))


def test_the_bank_limits_the_turn_and_the_force_is_linear_between_its_ends():
    turns = [SMALL_UAV.turn_rate_max(v) for v in (22.0, 5.0, 0.0)]
    assert turns == pytest.approx([GRAVITY / 22.0, SMALL_UAV.yaw_rate_max, SMALL_UAV.yaw_rate_max])
    forces = np.array([SMALL_UAV.force_limits(v) for v in (14.0, 23.0, 50.0)])
    np.testing.assert_allclose(forces, [(-1.2, 5.0), (-2.6, 3.0), (-4.0, 1.0)])


@pytest.mark.parametrize("rates", [[0.15], [0.15, 0.5], [0.5, 0.15]])  # of any limits together
@pytest.mark.parametrize("path_angle", [-1.0, -0.4, 0.0, 0.5, 1.0])
def test_however_steep_the_path_no_plan_changes_it_quicker_than_the_aircraft_can(path_angle, rates):
    limits = [PathAngle(-0.2, 0.2), *map(PitchRate, rates), YawRate(), Acceleration()]
    told = [limit.numbers(np.zeros((1, 3)))[0] for limit in limits]
    motion = Motion(300.0, 0.0, 100.0, path_angle, 22.0)
    middle, half = input_span(limits, told, motion, np)
    assert abs(middle[1]) + half[1] <= 0.15
    assert half[1] > 0.0


def test_the_least_thrust_limits_the_climb_that_holds_airspeed():
    lower, upper = SMALL_UAV.path_angle_limits(32.0)
    assert (lower, math.sin(upper)) == pytest.approx((SMALL_UAV.path_angle_min, 1.0 / GRAVITY))
    assert SMALL_UAV.path_angle_limits(14.0)[1] == SMALL_UAV.path_angle_max


def test_the_smallest_radius_is_what_the_sharpest_turn_needs():
    """The turn rate round the circle, from the motion itself: s t - c is the air velocity."""
    drift, speed = np.array([6.0, -3.0, 1.0]), 22.0
    d = SMALL_UAV.smallest_radius(speed, drift)
    phi = np.linspace(-np.pi, np.pi, 20001)
    tangent = np.array([-np.sin(phi), np.cos(phi)])
    along = drift[:2] @ tangent
    level = np.sqrt(speed**2 - drift[2] ** 2)
    s = along + np.sqrt(level**2 - drift[:2] @ drift[:2] + along**2)
    air = s * tangent - drift[:2, None]
    np.testing.assert_allclose(np.hypot(*air), level)
    heading = np.unwrap(np.arctan2(air[1], air[0]))
    rate = np.gradient(heading, phi) * s / d
    assert rate[1:-1].max() == pytest.approx(SMALL_UAV.turn_rate_max(speed), rel=1e-5)
    assert SMALL_UAV.smallest_radius(10.0, [11.0, 0, 0]) == math.inf


@given(st.tuples(anything, anything, anything), anything, anything)
def test_clipped_inputs_are_finite_and_inside(inputs, airspeed, path_angle):
    turn, pitch, acceleration = SMALL_UAV.clip(inputs, airspeed, path_angle)
    assert abs(turn) <= SMALL_UAV.yaw_rate_max
    if airspeed > 0 and math.isfinite(airspeed):
        assert abs(turn) * airspeed <= GRAVITY * math.tan(SMALL_UAV.bank_max) * (1 + 1e-12)
    assert abs(pitch) <= SMALL_UAV.pitch_rate_max
    assert SMALL_UAV.acceleration_min <= acceleration <= SMALL_UAV.acceleration_max


@given(
    st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9)),
    st.floats(14.0, 32.0),
    st.floats(math.radians(-9.0), math.radians(14.0)),
)
def test_inside_the_envelope_the_energy_is_there(inputs, airspeed, path_angle):
    acceleration = SMALL_UAV.clip(inputs, airspeed, path_angle)[2]
    lower, upper = SMALL_UAV.force_limits(airspeed)
    weight = GRAVITY * math.sin(path_angle)
    if lower - weight <= SMALL_UAV.acceleration_max and upper - weight >= -1.5:
        assert lower - 1e-12 <= weight + acceleration <= upper + 1e-12


@given(st.integers(0, 2**32 - 1))
def test_held_to_it_the_aircraft_stays_inside_whatever_is_asked(seed):
    random = np.random.default_rng(seed)
    state = np.array([0.0, 0.0, 100.0, 0.0, 0.0, 22.0])
    for asked in np.repeat(random.uniform(-9.0, 9.0, (20, 3)), 20, axis=0):
        state = advance(state, SMALL_UAV.clip(asked, state[5], state[4]), 0.05)
        assert SMALL_UAV.path_angle_min - 1e-9 <= state[4] <= SMALL_UAV.path_angle_max + 1e-9
        assert 14.0 - 0.05 <= state[5] <= 32.0 + 0.05


def test_what_can_be_flown_is_neither_changed_nor_refused():
    np.testing.assert_array_equal(SMALL_UAV.clip([0.3, -0.1, 0.5], 22.0, 0.05), [0.3, -0.1, 0.5])
    assert SMALL_UAV.refusal(Orbit(300.0, 120.0, 22.0), [8.0, 0.0, 0.0]) == ""


@pytest.mark.parametrize(
    ("orbit", "drift", "words"),
    [
        (
            Orbit(60.0, 0.0, 22.0),
            [8.0, 0.0, 0.0],
            [
                "an orbit of 60.0 m range at 22 m/s needs a turn rate of 0.682 rad/s where the "
                "drift of 8.0 m/s follows the flight, bank 45 deg allows 0.446 rad/s",
                "the nearest orbit that can be flown has a range of 98.6 m",
            ],
        ),
        (Orbit(40.0, 0.0, 22.0), STILL, ["needs a turn rate of 0.55 rad/s, bank 45 deg"]),
        (Orbit(300.0, 0.0, 40.0), STILL, ["40 m/s is not between 14 and 32", "of 32.0 m/s"]),
        (Orbit(300.0, 0.0, 22.0), [20.0, 0, 0], ["a drift of 20.0 m/s is too much", "22.3 m/s"]),
        (Orbit(300.0, 0.0, 32.0), [0, 0, -4.0], ["path angle of 7.2 deg cannot be held"]),
        (Orbit(300.0, 0.0, 22.0), [0, 0, 25.0], ["path angle of -90 deg cannot be held"]),
        (Orbit(300.0, 0.0, 22.0), [40.0, 0, 0], ["no orbit can be flown in a drift of 40.0 m/s"]),
    ],
)
def test_a_refusal_says_why_and_what_would_do(orbit, drift, words):
    refusal = SMALL_UAV.refusal(orbit, drift)
    for part in words:
        assert part in refusal


def test_too_near_to_the_target_is_refused():
    refusal = Envelope(**VALUES, distance_min=400.0).refusal(Orbit(300.0, 120.0, 22.0), STILL)
    assert "nearer to the target than the 400.0 m allowed" in refusal
    assert "has a range of 400.0 m" in refusal


@given(orbits(), drifts)
def test_the_nearest_orbit_can_be_flown(orbit, drift):
    try:
        nearest = SMALL_UAV.nearest_orbit(orbit, drift)
    except ValueError:
        assert "no orbit" in SMALL_UAV.refusal(orbit, drift)
        return
    assert SMALL_UAV.refusal(nearest, drift) == ""
    assert (nearest.altitude, nearest.direction) == (orbit.altitude, orbit.direction)
    if not SMALL_UAV.refusal(orbit, drift):
        assert nearest == orbit


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("airspeed_min", -1.0),
        ("airspeed_max", 14.0),
        ("path_angle_min", 0.1),
        ("path_angle_max", 2.0),
        ("bank_max", 0.0),
        ("yaw_rate_max", math.nan),
        ("pitch_rate_max", -0.1),
        ("acceleration_min", 0.0),
        ("acceleration_max", math.inf),
        ("force_max", (5.0, -4.0)),
        ("height_min", math.nan),
        ("distance_min", -1.0),
        ("fence_radius", -1.0),
    ],
)
def test_limits_that_contradict_themselves_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"parameter '{name}' is"):
        Envelope(**{**VALUES, name: value})


@given(st.floats(15.0, 30.0), st.floats(0.0, 8.0), st.floats(0.9, 1.1))
def test_a_turn_is_refused_where_no_plan_may_end_on_it(speed, along, share):
    drift = [along, 0.0, 0.0]
    tight = SMALL_UAV.smallest_radius(speed, drift) / 0.95
    asked = Orbit(share * tight, 0.0, speed)
    shape = OrbitShape(asked.radius, 0.0, speed, asked.range, along)
    kinds = [SMALL_UAV.find(kind) for kind in (Bank, YawRate)]
    ends = [limit.orbit(shape, limit.numbers(np.zeros((1, 3)))[0], np).value for limit in kinds]
    if abs(max(ends) - 1.0) > 1e-9:
        assert ("turn rate" in SMALL_UAV.refusal(asked, drift)) == (max(ends) > 1.0)


def test_an_orbit_below_the_least_height_is_refused_in_words():
    low, envelope = Orbit(300.0, 5.0, 22.0), Envelope(**VALUES, height_min=30.0)
    assert envelope.refusal(low, STILL) == ""  # nobody knows how high the target is
    assert envelope.refusal(low, STILL, 40.0) == ""
    words = envelope.refusal(low, STILL, 0.0)
    assert "altitude of 5 m above a target at 0 m is below the least height of 30 m" in words
    assert "the least altitude is 30 m" in words


def test_a_configuration_below_the_least_height_is_refused():
    with pytest.raises(ParameterError, match="below the least height of 30 m"):
        load_configuration("small_uav", ["nmpc_controller.altitude=5.0"])
    raised = ["nmpc_controller.altitude=5.0", "target_publisher.position=[0, 0, 40]"]
    assert load_configuration("small_uav", raised).controller.altitude == 5.0


def test_a_change_below_the_least_height_is_refused_in_flight():
    controller = Controller(load_configuration("small_uav", ["nmpc_controller.law=l1"]).controller)
    controller.change(altitude=25.0)  # the target's height is not known yet
    controller.see_target(0.0, [0.0, 0.0, 2.0])
    with pytest.raises(ParameterError, match="altitude of 5 m above a target at 2 m"):
        controller.change(altitude=5.0)
    assert controller.parameters.altitude == 25.0
    controller.change(altitude=28.5)
