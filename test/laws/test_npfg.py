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
from small_uav import SMALL_UAV, fly, situation

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS, Orbit
from uav_tracking_mpc.laws.npfg import DAMPING, PERIOD, NPFGLoiter

V = 22.0
R = Orbit(300.0, 120.0, V).radius


def law(direction="clockwise", **values):
    return NPFGLoiter(Orbit(300.0, 120.0, V, direction), SMALL_UAV, **values)


def on_the_circle(drift, sense=1.0, slip=0.0):
    """East of the target; the relative velocity points North, times sense, at a slip of 0."""
    psi = sense * math.pi / 2 + math.asin(sense * drift[0] / V) + slip
    return situation(R, heading=psi, drift=drift)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (6.0, 9.0, 0.0), (-10.0, -3.0, 0.0)])
def test_on_the_circle_the_relative_velocity_turns_as_the_circle_does(direction, drift):
    """w' = u_psi V n, and the course of w turns by w x w' / w^2 = |w| / R."""
    sense = 1.0 if direction == "counter_clockwise" else -1.0
    on = on_the_circle(drift, sense)
    turn_rate, climb, acceleration = law(direction).inputs(on)
    w, n = on.relative_velocity, np.array([-np.sin(on.heading), np.cos(on.heading)])
    wx_rate, wy_rate = turn_rate * V * n
    course_rate = (w[0] * wy_rate - w[1] * wx_rate) / (w @ w)
    assert course_rate == pytest.approx(sense * np.linalg.norm(w) / R)
    assert (climb, acceleration) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_off_the_circle_the_bearing_is_that_of_the_look_ahead_angle():
    """a = 4 pi zeta V sin(eta) / T + sin(lambda)^2 V^2 / d, eta = pi/2 - lambda."""
    e = 20.0
    angle = 0.5 * math.pi * (1.0 - e / (V * DAMPING * PERIOD)) ** 2
    gain = 4.0 * math.pi * DAMPING / PERIOD
    lateral, speed = law("counter_clockwise").guide(situation(R + e, heading=math.pi / 2))
    circle = math.sin(angle) ** 2 * V * V / (R + e)
    assert lateral == pytest.approx(gain * V * math.cos(angle) + circle)
    assert speed == V
    inside, _ = law("counter_clockwise").guide(situation(R - e, heading=math.pi / 2))
    circle = math.sin(angle) ** 2 * V * V / (R - e)
    assert inside == pytest.approx(-gain * V * math.cos(angle) + circle)


def test_about_the_circle_period_and_damping_are_those_of_a_pendulum():
    """Outside by e: omega^2 e more; outbound with e': 2 zeta omega e' more."""
    loiter = law("counter_clockwise", period=12.0, damping=0.8)
    omega, e, slip = 2 * np.pi / 12.0, 1e-3, 1e-3
    outside, _ = loiter.guide(situation(R + e, heading=np.pi / 2))
    assert outside - V**2 / (R + e) == pytest.approx(omega**2 * e, rel=1e-3)
    outbound, _ = loiter.guide(situation(R, heading=np.pi / 2 - slip))
    centripetal = V**2 * np.cos(slip) / R
    assert outbound - centripetal == pytest.approx(2 * 0.8 * omega * V * np.sin(slip))


def test_far_away_it_flies_to_the_target_and_turns_no_harder_beyond_a_right_angle():
    loiter, gain = law(), 4.0 * math.pi * DAMPING / PERIOD
    for psi in (0.0, 1.0, -1.5):
        lateral, _ = loiter.guide(situation(5e3, heading=psi))
        assert abs(lateral) == pytest.approx(gain * V)
    assert loiter.guide(situation(5e3, heading=math.pi - 0.1))[0] == pytest.approx(
        gain * V * math.sin(0.1)
    )


@pytest.mark.parametrize(
    ("asked", "drift", "expected"),
    [
        (1.0, 0.0, 1.5 * math.pi * 0.5 / 0.7),  # roll lag, straight
        (1.0, -8.0, 1.5 * 4.0 * math.pi * 0.5 * 0.7),  # roll lag, curved in wind
        (10.0, -8.0, 10.0),
        # 4 pi zeta over the turn rate V / R and the wind factor 2 (1 - sqrt(1 - c / V))
        (90.0, -20.0, 4.0 * math.pi * 0.7 * R / V / (2.0 * (1.0 - math.sqrt(1.0 - 20.0 / V)))),
    ],
)
def test_the_period_is_bounded(asked, drift, expected):
    """Seen in the acceleration per heading error: 4 pi zeta V / T."""
    loiter = law("counter_clockwise", period=asked)
    straight, slipping = (
        loiter.guide(on_the_circle((0.0, -drift, 0.0), slip=slip))[0] for slip in (0.0, 1e-6)
    )
    # The feed-forward changes with the slip only by its square.
    assert (straight - slipping) / (V * 1e-6) == pytest.approx(
        4.0 * math.pi * 0.7 / expected, rel=1e-4
    )


@pytest.mark.parametrize(
    ("drift", "speed"),
    [
        ((0.0, 12.0, 0.0), V),
        ((0.0, -17.0, 0.0), V),  # 5 m/s are left
        ((0.0, -20.0, 0.0), 25.0),
        ((6.0, -20.0, 0.0), math.hypot(25.0, 6.0)),
        ((25.0, 10.0, 0.0), 25.0),  # along and sideways
        ((0.0, -28.0, 0.0), 32.0),
        ((0.0, -40.0, 0.0), 32.0),
    ],
)
def test_the_airspeed_keeps_5_metres_per_second_along_the_bearing(drift, speed):
    loiter = law("counter_clockwise")
    on = situation(R, heading=math.pi / 2, drift=drift)
    assert loiter.guide(on)[1] == pytest.approx(speed)
    acceleration = loiter.inputs(on)[2]
    assert (acceleration > 0.0) == (speed > V)


def test_the_wind_triangle_leads_the_relative_velocity_along_the_bearing():
    """No turn beyond the circle's is asked for once the velocity has the bearing, only then."""
    drift = (7.0, 4.0, 0.0)
    still = law().guide(situation(900.0, heading=math.pi))[0]
    assert still == pytest.approx(0.0, abs=1e-9)  # the bearing is West
    psi = math.pi + math.asin(4.0 / V)  # makes up for the drift to the North
    assert law().guide(situation(900.0, heading=psi, drift=drift))[0] == pytest.approx(
        0.0, abs=1e-9
    )
    assert law().guide(situation(900.0, heading=psi - 0.1, drift=drift))[0] > 0.5


@pytest.mark.parametrize("drift", [(10.0, -35.0, 0.0), (-12.0, -31.0, 0.0), (40.0, 10.0, 0.0)])
def test_what_no_airspeed_makes_up_for_is_met_as_infeasible_air_vel_ref_says(drift):
    """With the bearing b the nose goes along sqrt(c^2 - v_max^2) b - c."""
    bearing, c = np.array([0.0, 1.0]), np.array(drift[:2])
    assert np.linalg.norm(c) > SMALL_UAV.airspeed_max
    east, north = math.sqrt(c @ c - SMALL_UAV.airspeed_max**2) * bearing - c
    psi = math.atan2(north, east)
    loiter, gain = law("counter_clockwise"), 4.0 * math.pi * DAMPING / PERIOD
    for slip in (-0.1, 0.0, 0.1):
        lateral, _ = loiter.guide(situation(R, heading=psi + slip, drift=drift))
        assert lateral == pytest.approx(-gain * V * math.sin(slip), abs=1e-9)


def test_in_a_wind_beyond_its_airspeed_it_speeds_up_and_returns():
    loiter = law()
    start = [500.0, 0.0, 120.0, 0.0, 0.0, 22.0]
    offsets, vehicles, _ = fly(loiter, start, 120.0, (25.0, 0.0, 0.0))
    distance = np.linalg.norm(offsets, axis=1)
    assert vehicles[:, 5].max() > 28.0
    assert distance[-1] < 350.0
    assert vehicles[:, 5].max() < SMALL_UAV.airspeed_max + 1e-6


def test_from_a_wind_beyond_every_airspeed_it_is_blown_away_as_slowly_as_can_be():
    """40 m/s of wind, at most 32 m/s through the air: 8 m/s, nose into the wind."""
    _, vehicles, _ = fly(law(), [R, 0.0, 120.0, 1.0, 0.0, 22.0], 200.0, (40.0, 0.0, 0.0))
    _, _, _, heading, path_angle, airspeed = vehicles[-1]
    assert airspeed == pytest.approx(SMALL_UAV.airspeed_max, rel=1e-3)
    east = 40.0 + airspeed * math.cos(heading) * math.cos(path_angle)
    assert east == pytest.approx(40.0 - SMALL_UAV.airspeed_max, abs=0.2)
