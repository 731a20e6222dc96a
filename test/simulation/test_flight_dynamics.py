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

"""The aircraft itself: its trim, its place on the ellipsoid, its coefficients, its air."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import GRAVITY, gust_scales
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.flight_dynamics import RATE, Airframe, AirframeError, Surfaces

MASS, AREA, SPAN, CHORD = 11.0, 0.55, 2.8956, 0.18994  # table E.1


START = SimulatorParameters(
    initial_position=(0.0, 0.0, 100.0), initial_path_angle=0.0, initial_speed=22.0, speed_max=99.0
)


def started(seed=0, **changed):
    return Airframe(replace(START, **changed), seed)


def flown(steps, surfaces=(), **changed):
    """After so many steps from the start with the surfaces of its trim, but for some."""
    airframe = started(**changed)
    for _ in range(steps):
        airframe.step(airframe.trim._replace(**dict(surfaces)))
    return airframe


@pytest.mark.parametrize(("airspeed", "path_angle"), [(16.0, 0.0), (22.0, 0.1), (28.0, -0.1)])
def test_trimmed_flight_is_steady(airspeed, path_angle):
    start = {"initial_speed": airspeed, "initial_path_angle": path_angle, "initial_heading": 1.0}
    airframe = flown(2 * RATE, **start)
    seen = airframe.flown
    assert seen.airspeed == pytest.approx(airspeed, abs=0.05)
    assert (seen.path_angle, airframe.yaw) == pytest.approx((path_angle, 1.0), abs=5e-3)
    assert abs(seen.roll_rate) + abs(seen.pitch_rate) + abs(seen.yaw_rate) < 2e-3


def test_lift_bears_the_weight():
    assert started().flown.pitch == pytest.approx(level_alpha(22.0), abs=2e-3)


def level_alpha(airspeed):
    """m g = q S (C_L0 + C_L_alpha alpha + C_L_delta_e delta_e), C_m = 0, thrust along the nose."""
    pressure = 0.5 * 1.225 * (1.0 - 2.2558e-5 * 100.0) ** 4.2559 * airspeed**2 * AREA
    elevator_by_alpha = np.array([0.0135, -2.74]) / 0.99
    slope = 5.61 + 0.13 * elevator_by_alpha[1]
    lift = MASS * GRAVITY / pressure
    alpha = (lift - 0.23 - 0.13 * elevator_by_alpha[0]) / slope
    thrust = 0.043 + lift**2 / (math.pi * 0.9 * SPAN**2 / AREA)  # drag, of which a part lifts
    return alpha - thrust * alpha / slope


def test_position_and_velocity_are_those_that_are_asked_for():
    wind = (3.0, -4.0, 1.0)
    airframe = started(initial_position=(5000.0, -3000.0, 250.0), initial_heading=2.0, wind=wind)
    np.testing.assert_allclose(airframe.position, [5000.0, -3000.0, 250.0], atol=1e-4)
    air = 22.0 * np.array([math.cos(2.0), math.sin(2.0), 0.0])
    # The plane of the map and the level there differ by 6 km / 6400 km.
    np.testing.assert_allclose(airframe.ground_velocity, air + wind, atol=0.03)
    np.testing.assert_allclose(airframe.wind, wind, atol=1e-9)
    before = airframe.position
    for _ in range(RATE):
        airframe.step(airframe.trim)
    np.testing.assert_allclose(airframe.position - before, air + wind, atol=0.1)


def test_moments_turn_the_aircraft_as_the_books_signs_say():
    for surfaces, rate in (
        ({"aileron": 0.1}, lambda flown: flown.roll_rate),
        ({"elevator": -0.3}, lambda flown: flown.pitch_rate),
        ({"rudder": -0.1}, lambda flown: flown.yaw_rate),
    ):
        assert rate(flown(RATE // 5, surfaces).flown) > 0.02, surfaces


def test_rotation_is_that_of_the_books_equations():
    airframe = flown(RATE // 5, {"aileron": 0.1, "rudder": 0.05, "elevator": -0.3})
    fdm = airframe._fdm
    p, q, r = (fdm[f"velocities/{axis}-rad_sec"] for axis in "pqr")
    alpha, beta = fdm["aero/alpha-rad"], fdm["aero/beta-rad"]
    aileron, elevator, rudder = (fdm[f"fcs/{s}-rad"] for s in ("aileron", "elevator", "rudder"))
    speed = airframe.flown.airspeed
    pressure = 0.5 * 515.378818 * fdm["atmosphere/rho-slugs_ft3"] * speed**2 * AREA
    span, chord = SPAN / (2.0 * speed), CHORD / (2.0 * speed)
    lateral = -0.13 * beta + span * (-0.51 * p + 0.25 * r) + 0.17 * aileron + 0.0024 * rudder
    pitching = 0.0135 - 2.74 * alpha - 38.21 * chord * q - 0.99 * elevator
    yawing = 0.073 * beta + span * (-0.069 * p - 0.095 * r) - 0.011 * aileron - 0.069 * rudder
    moments = pressure * np.array([SPAN * lateral, CHORD * pitching, SPAN * yawing])
    moments[0] -= fdm["propulsion/torque-newtonmetre"]
    inertia = np.array([[0.8244, 0.0, -0.1204], [0.0, 1.135, 0.0], [-0.1204, 0.0, 1.759]])
    spin = np.array([p, q, r])
    expected = np.linalg.solve(inertia, moments - np.cross(spin, inertia @ spin))
    found = [fdm[f"accelerations/{axis}dot-rad_sec2"] for axis in "pqr"]
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=2e-3)


def test_motor_and_propeller_balance():
    airframe = started()
    fdm, density = airframe._fdm, 515.378818 * airframe._fdm["atmosphere/rho-slugs_ft3"]
    turns = fdm["propulsion/speed-rad_sec"] / (2.0 * math.pi)
    advance = 22.0 / (turns * 0.508)
    power = -0.01664 * advance**2 + 0.004970 * advance + 0.005230
    push = -0.1079 * advance**2 - 0.06044 * advance + 0.09357
    torque = fdm["propulsion/torque-newtonmetre"]
    assert torque == pytest.approx(density * turns**2 * 0.508**5 * power, rel=1e-6)
    thrust = density * turns**2 * 0.508**4 * push
    assert fdm["propulsion/thrust-newton"] == pytest.approx(thrust, rel=1e-6)
    # Q_motor = K_Q ((V_in - K_V Omega) / R - i_0)
    current = (44.4 * airframe.trim.throttle - 0.0659 * 2.0 * math.pi * turns) / 0.042
    assert torque == pytest.approx(0.0659 * (current - 1.5), rel=1e-4)


def test_servos_lag_and_have_ends():
    airframe = started()
    airframe.step(airframe.trim)
    airframe.step(Surfaces(0.0, 0.0, 0.0, 1.0))
    fdm = airframe._fdm
    assert airframe.trim.throttle < fdm["fcs/throttle-norm"] < airframe.trim.throttle + 4.0 / RATE
    for _ in range(RATE // 20):
        airframe.step(Surfaces(3.0, airframe.trim.elevator, 0.0, 2.0))
    # 5 rad/s
    assert 0.1 < fdm["fcs/aileron-rad"] < 5.0 * 0.06
    for _ in range(RATE // 2):
        fdm["fcs/aileron-demand-rad"] = 3.0
        fdm.run()
    assert fdm["fcs/aileron-rad"] == pytest.approx(0.7854)


def test_turbulence_is_as_strong_as_drydens_and_follows_its_seed():
    scales = gust_scales(100.0, 15.4)
    winds = {}
    for seed, seconds in ((1, 100), (2, 100), (1, 10)):
        airframe = started(seed, gust_intensity=15.4, initial_speed=25.0)
        fdm, seen = airframe._fdm, []
        for _ in range(seconds * RATE):  # where it is does not matter, but height and speed do
            fdm["fcs/throttle-demand-norm"] = 0.7
            fdm["position/h-sl-meters"] = 100.0
            fdm["attitude/phi-rad"] = fdm["attitude/theta-rad"] = 0.0
            fdm["velocities/u-fps"] = 25.0 / 0.3048
            fdm.run()
            seen.append(airframe.wind)
        if seed in winds:
            np.testing.assert_array_equal(winds[seed][: len(seen)], seen)
        else:
            winds[seed] = np.array(seen)
    assert not np.array_equal(winds[1], winds[2])
    deviations = np.std(np.concatenate([winds[1], winds[2]]), axis=0)
    expected = [scales.level, scales.level, scales.vertical]
    np.testing.assert_allclose(deviations, expected, rtol=0.4)


def test_what_cannot_fly_is_refused():
    with pytest.raises(AirframeError, match="no steady flight at 60 m/s"):
        started(initial_speed=60.0)
    with pytest.raises(AirframeError, match="control is lost"):
        flown(5 * RATE, {"elevator": -0.78, "throttle": 0.0})


def test_without_jsbsim_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    with pytest.raises(ImportError) as refused:
        started()
    assert 'pip install "uav_tracking_mpc[jsbsim]"' in str(refused.value)


def test_it_says_nothing_on_the_terminal(capfd):
    airframe = started(gust_intensity=15.0)
    airframe.step(airframe.trim)
    assert capfd.readouterr() == ("", "")
