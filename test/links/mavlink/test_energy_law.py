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

"""Path angle and airspeed follow the inputs like the controller's model; limits always hold."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.links.mavlink.energy_law import (
    LONGEST_STEP,
    PATH_LAG,
    SPEED_LAG,
    EnergyLaw,
    EnergyLimits,
    FlownPath,
)
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation import flight_dynamics
from uav_tracking_mpc.simulation.plants import jsbsim

CRUISE = 22.0
LIMITS = EnergyLimits(CRUISE, 14.0, 32.0)
STEP = 0.005  # s of the simulation; the law is asked at 25 Hz
LEVEL = FlownPath(0.0, 0.0, CRUISE, 0.0)


class PointMass:
    """Pitch, bank and thrust lag behind their commands, the path behind the pitch; drag is a polar.

    Small-angle, m v chi' = L_alpha (alpha - alpha_level): T chi' = theta - alpha - chi.
    """

    def __init__(self, pitch_time=0.4, lift_time=0.25, incidence=0.05, climb=5.0, trim=0.6):
        self.time, self.path_angle, self.airspeed, self.bank = 0.0, 0.0, CRUISE, 0.0
        self.pitch_time, self.lift_time, self.incidence = pitch_time, lift_time, incidence
        self.climb, self.trim, self.sink = climb, trim, 2.0
        self.thrust, self.pitch = trim, incidence + 0.08
        self.stuck = False

    def fly(self, pitch, thrust, bank):
        self.time += STEP
        self.pitch += (pitch - self.pitch) * STEP / self.pitch_time
        self.thrust += (thrust - self.thrust) * STEP / 0.15
        self.bank += (bank - self.bank) * STEP / 0.4
        load = 1.0 / math.cos(self.bank)
        alpha = self.incidence + 0.08 * load * (CRUISE / self.airspeed) ** 2
        lifted = self.pitch - alpha * math.cos(self.bank) - self.path_angle
        self.path_angle += lifted * STEP / self.lift_time
        above = self.thrust - self.trim
        room = 1.0 - self.trim if above > 0.0 else self.trim
        excess = above / room * (self.climb if above > 0.0 else self.sink)
        parasitic = (self.airspeed / CRUISE) ** 2
        induced = (load * CRUISE / self.airspeed) ** 2
        drag = self.sink * (0.5 * parasitic + 0.5 * induced - 1.0)
        force = GRAVITY * (excess - drag) / CRUISE - GRAVITY * math.sin(self.path_angle)
        self.airspeed += force * STEP

    @property
    def flown(self):
        return FlownPath(self.time, self.path_angle, self.airspeed, self.bank)


def flight(plant, inputs, duration, bank=lambda time: 0.0, limits=LIMITS, every=8):
    """Path angle and airspeed at each step, and those of the controller's lagged model."""
    law, flown = EnergyLaw(limits), plant.flown
    law.begin(flown, plant.pitch, plant.thrust)
    chi, v, omega, gain = flown.path_angle, flown.airspeed, 0.0, 0.0
    rows, command = [], (law.pitch, law.thrust)
    for tick in range(round(duration / STEP)):
        u_chi, u_v = inputs(plant.time)
        if tick % every == every - 1:
            command = law.step(u_chi, u_v, plant.flown)
        plant.fly(*command, bank(plant.time))
        omega += (u_chi - omega) * STEP / PATH_LAG
        gain += (u_v - gain) * STEP / SPEED_LAG
        chi, v = chi + omega * STEP, v + gain * STEP
        rows.append((plant.flown.path_angle, chi, plant.flown.airspeed, v))
    return np.array(rows).T


def doublets(time):
    climb = {5: 0.1, 11: -0.1}.get(int(time), 0.0)
    gain = 1.0 if 18.0 <= time < 20.0 else -0.6 if 27.0 <= time < 30.0 else 0.0
    return climb, gain


@pytest.mark.parametrize("bank", [0.0, 0.5])
@pytest.mark.parametrize(
    "plant", [{}, {"pitch_time": 0.3, "lift_time": 0.4}, {"pitch_time": 0.5, "lift_time": 0.15}]
)
def test_path_angle_and_airspeed_follow_the_lagged_model(plant, bank):
    path, wanted, airspeed, speed = flight(PointMass(**plant), doublets, 40.0, lambda _: bank)
    # Of a climb by 0.1 rad, and of 2 m/s: a twentieth.
    assert np.std(path - wanted) < 0.005
    assert np.abs(airspeed - speed).max() < 0.5


TRIM = 0.55  # thrust that the law is told, 0.15 too little
ATTITUDE_TIME, RATE_MAX = 0.4, 1.05  # s, rad/s: FW_P_TC, FW_P_RMAX_POS


class Attitude:
    """Six degrees of freedom behind attitude loops as PX4 has them.

    Elevator by a pitch set-point: a rate of the error, and the rate of the turn. Bank and rudder
    are those of the plant's own loops; gains of the rate are theirs.
    """

    def __init__(self):
        parameters = replace(
            load_configuration("jsbsim_uav").simulator,
            initial_position=(0.0, 0.0, 150.0),
            initial_path_angle=0.0,
            initial_speed=CRUISE,
        )
        self.airframe, self.time = flight_dynamics.Airframe(parameters), 0.0
        flown, trim = self.airframe.flown, self.airframe.trim
        self.loops = jsbsim.FlightControl(parameters, trim, flown)
        self.pitch, self.thrust, self._elevator = flown.pitch, trim.throttle, trim.elevator

    @property
    def flown(self):
        flown = self.airframe.flown
        return FlownPath(self.time, flown.path_angle, flown.airspeed, flown.bank)

    def fly(self, pitch, thrust, bank):
        flown = self.airframe.flown
        weaker = (CRUISE / flown.airspeed) ** 2
        turn = -GRAVITY * math.tan(bank) / flown.airspeed / math.cos(flown.path_angle)
        aileron = self.loops._aileron(turn, flown, weaker, STEP)
        rudder = self.loops._rudder(aileron, flown, weaker, STEP)
        rise = min(max((pitch - flown.pitch) / ATTITUDE_TIME, -RATE_MAX), RATE_MAX)
        yaw_rate = GRAVITY * math.tan(flown.bank) * math.cos(flown.pitch) / flown.airspeed
        wanted = rise * math.cos(flown.bank)
        wanted += yaw_rate * math.sin(flown.bank) * math.cos(flown.pitch)
        error = wanted - flown.pitch_rate
        forward = jsbsim.PITCH_FORWARD * CRUISE / flown.airspeed * wanted
        elevator = self._elevator - forward - weaker * jsbsim.PITCH_GAIN * error
        self._elevator -= weaker * jsbsim.PITCH_INTEGRAL * error * STEP
        self.airframe.step(flight_dynamics.Surfaces(aileron, elevator, rudder, thrust))
        self.time += STEP


@pytest.mark.parametrize("bank", [0.0, 0.2, 0.5])
def test_so_they_do_in_six_degrees_of_freedom(bank):
    pytest.importorskip("jsbsim")
    assert pytest.approx(1.0 / STEP) == flight_dynamics.RATE
    limits = EnergyLimits(CRUISE, 15.0, 30.0, trim=TRIM)
    rows = flight(
        Attitude(), doublets, 40.0, lambda time: bank * min(0.5 * time, 1.0), limits, every=4
    )
    path, wanted, airspeed, speed = rows[:, 800:]  # after 4 s
    assert np.sqrt(np.mean((path - wanted) ** 2)) < 0.015  # of a climb by 0.1 rad
    assert np.sqrt(np.mean((airspeed - speed) ** 2)) < 0.4  # of 2 m/s


@pytest.mark.parametrize("plant", [{"climb": 7.0, "trim": 0.5}, {"climb": 3.5, "trim": 0.7}])
def test_a_trim_and_an_engine_that_are_not_as_told_are_learnt(plant):
    path, _, airspeed, _ = flight(PointMass(**plant, incidence=0.1), lambda time: (0.0, 0.0), 60.0)
    assert np.abs(path[-1000:]).max() < 1e-3
    assert np.abs(airspeed[-1000:] - CRUISE).max() < 0.05


def settled(flown):
    """The law after 4 s of what is flown."""
    law = EnergyLaw(LIMITS)
    law.begin(flown, 0.1, LIMITS.trim)
    for tick in range(1, 100):
        law.step(0.0, 0.0, flown._replace(time=0.04 * tick))
    return law


def test_thin_air_takes_more_thrust():
    """PerformanceModel::getTrimThrottle: the root of the density at sea level over that there."""
    thin = LEVEL._replace(airspeed=1.1 * CRUISE, true_over_equivalent=1.1)
    thrusts = [settled(flown).thrust for flown in (LEVEL, thin)]
    assert thrusts[1] == pytest.approx(1.1 * thrusts[0], rel=1e-6)


@pytest.mark.parametrize(("airspeed", "trim"), [(14.0, 0.4), (18.0, 0.5), (22.0, 0.6), (32.0, 0.9)])
def test_trim_by_airspeed_is_interpolated(airspeed, trim):
    law = EnergyLaw(LIMITS._replace(trim_slow=0.4, trim_fast=0.9))
    flown = LEVEL._replace(airspeed=airspeed)
    law.begin(flown, 0.1, trim)
    law.step(0.0, 0.0, flown._replace(time=0.04))
    assert law.thrust == pytest.approx(trim)


def test_below_the_least_airspeed_the_nose_goes_down_and_the_thrust_up():
    law = settled(LEVEL._replace(airspeed=12.0))
    assert law.thrust == LIMITS.thrust_max
    assert law.pitch < 0.1 - 0.05


def test_in_a_turn_the_least_airspeed_is_greater():
    """FW_AIRSPD_MIN sqrt(n): what is enough in level flight is too little at a load factor of 2."""
    law, banked = EnergyLaw(LIMITS), LEVEL._replace(airspeed=16.0, bank=math.radians(60.0))
    law.begin(banked, 0.1, 0.6)
    assert law.airspeed == pytest.approx(14.0 * math.sqrt(2.0))


def test_what_the_engine_cannot_do_is_not_stored_up():
    """An acceleration to the greatest airspeed and on: the surplus is small, and it settles."""
    plant = PointMass()
    _, _, airspeed, _ = flight(plant, lambda t: (0.0, 1.5 if t < 20.0 else 0.0), 60.0)
    assert np.abs(np.diff(airspeed)).max() < 2.0 * STEP  # m/s
    assert airspeed.max() < LIMITS.airspeed_max + 1.0  # by what lags: 1.5 m/s^2 over 0.4 s
    assert abs(airspeed[-1] - airspeed[-1000]) < 0.05


def test_after_a_pause_it_begins_anew():
    law = EnergyLaw(LIMITS)
    law.begin(LEVEL, 0.1, 0.6)
    law.step(0.0, 0.0, LEVEL._replace(time=0.04))
    law.step(0.0, 0.0, FlownPath(5.0, 0.12, 25.0, 0.0))
    assert (law.path_angle, law.airspeed) == pytest.approx((0.12, 25.0))


ANY = st.floats(width=32) | st.floats(-1.0, 1.0)
FLOWN = st.tuples(
    st.floats(1e-4, 2.0 * LONGEST_STEP),
    ANY | st.floats(-0.5, 0.5),
    ANY | st.floats(10.0, 40.0),
    ANY,
    st.sampled_from([1.0, 1.05, math.nan]),
)


@given(st.lists(st.tuples(ANY, ANY, FLOWN), min_size=1, max_size=30))
def test_limits_and_slew_hold_whatever_comes_in(steps):
    law = EnergyLaw(LIMITS)
    law.begin(LEVEL, 0.1, 0.6)
    time, given_all = 0.0, [(law.pitch, law.thrust)]
    for u_chi, u_v, (duration, *flown) in steps:
        time += duration
        given_all.append(law.step(u_chi, u_v, FlownPath(time, *flown)))
    for (pitch, thrust), (later, stronger) in pairwise(given_all):
        assert LIMITS.pitch_min <= later <= LIMITS.pitch_max
        assert LIMITS.thrust_min <= stronger <= LIMITS.thrust_max
        assert abs(later - pitch) <= LIMITS.pitch_slew * LONGEST_STEP + 1e-9
        assert abs(stronger - thrust) <= LIMITS.thrust_slew * LONGEST_STEP + 1e-9
