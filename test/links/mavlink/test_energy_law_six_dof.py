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

"""The energy law in six degrees of freedom, behind attitude loops as PX4 has them."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.links.mavlink.energy_law import (
    PATH_LAG,
    SPEED_LAG,
    EnergyLaw,
    EnergyLimits,
    FlownPath,
)
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation import flight_control, flight_dynamics

pytest.importorskip("jsbsim")

RATE = flight_dynamics.RATE
CRUISE, TRIM = 22.0, 0.55  # m/s; the thrust that the law is told, 0.15 too little
ATTITUDE_TIME, RATE_MAX = 0.4, 1.05  # s, rad/s: FW_P_TC, FW_P_RMAX_POS


class Attitude:
    """Elevator by a pitch set-point: a rate of the error, and the rate of the turn.

    Bank and rudder are those of the plant's own loops; gains of the rate are theirs.
    """

    def __init__(self, start):
        self.airframe = flight_dynamics.Airframe(start)
        parameters = load_configuration("jsbsim_uav").simulator
        self.loops = flight_control.FlightControl(
            parameters, self.airframe.trim, self.airframe.flown
        )
        self._elevator = self.airframe.trim.elevator

    def fly(self, pitch, thrust, bank):
        flown = self.airframe.flown
        weaker = (CRUISE / flown.airspeed) ** 2
        turn = -GRAVITY * math.tan(bank) / flown.airspeed / math.cos(flown.path_angle)
        aileron = self.loops._aileron(turn, flown, weaker, 1.0 / RATE)
        rudder = self.loops._rudder(aileron, flown, weaker, 1.0 / RATE)
        rise = min(max((pitch - flown.pitch) / ATTITUDE_TIME, -RATE_MAX), RATE_MAX)
        yaw_rate = GRAVITY * math.tan(flown.bank) * math.cos(flown.pitch) / flown.airspeed
        wanted = rise * math.cos(flown.bank)
        wanted += yaw_rate * math.sin(flown.bank) * math.cos(flown.pitch)
        error = wanted - flown.pitch_rate
        forward = flight_control.PITCH_FORWARD * CRUISE / flown.airspeed * wanted
        elevator = self._elevator - forward - weaker * flight_control.PITCH_GAIN * error
        self._elevator -= weaker * flight_control.PITCH_INTEGRAL * error / RATE
        self.airframe.step(flight_dynamics.Surfaces(aileron, elevator, rudder, thrust))


def inputs(time):
    climb = {5: 0.1, 11: -0.1}.get(int(time), 0.0)
    gain = 1.0 if 20.0 <= time < 22.0 else -0.6 if 32.0 <= time < 35.0 else 0.0
    return climb, gain


@pytest.mark.parametrize("bank", [0.0, 0.2, 0.5])
def test_path_angle_and_airspeed_follow_the_lagged_model(bank):
    aircraft = Attitude(flight_dynamics.Start((0.0, 0.0, 150.0), 0.0, 0.0, CRUISE))
    law = EnergyLaw(EnergyLimits(CRUISE, 15.0, 30.0, trim=TRIM))
    flown = aircraft.airframe.flown
    law.begin(
        FlownPath(0.0, flown.path_angle, flown.airspeed, flown.bank),
        flown.pitch,
        aircraft.airframe.trim.throttle,
    )
    chi, v, omega, gained = flown.path_angle, flown.airspeed, 0.0, 0.0
    command, rows = (law.pitch, law.thrust), []
    for tick in range(40 * RATE):
        time, flown = tick / RATE, aircraft.airframe.flown
        u_chi, u_v = inputs(time)
        if tick % 4 == 3:  # 50 Hz
            path = FlownPath(time, flown.path_angle, flown.airspeed, flown.bank)
            command = law.step(u_chi, u_v, path)
        aircraft.fly(*command, bank * min(0.5 * time, 1.0))
        omega += (u_chi - omega) / PATH_LAG / RATE
        gained += (u_v - gained) / SPEED_LAG / RATE
        chi, v = chi + omega / RATE, v + gained / RATE
        if time > 4.0:
            rows.append((flown.path_angle - chi, flown.airspeed - v))
    path_error, speed_error = np.sqrt(np.mean(np.square(rows), axis=0))
    assert path_error < 0.015  # of a climb by 0.1 rad
    assert speed_error < 0.4  # of 2 m/s
