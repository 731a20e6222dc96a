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

"""The autopilot's inner loops: bank, climb and airspeed to the plant's inputs, and its circles."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.autopilot.airframe import STEEPEST, Airframe, Engine
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.energy_hold import HoldConstants, hold
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, turn_rate_from_bank
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws.l1 import L1Loiter
from uav_tracking_mpc.limits.envelope import Envelope
from uav_tracking_mpc.settings.simulator import SimulatorParameters

LEAST_RADIUS, GREATEST_RADIUS = 1.0, 1e6  # m
LEAST_PERIOD, LEAST_DAMPING = 1.0, 0.1  # s, -, of the L1 law


class Loiter(NamedTuple):
    """A horizontal circle.

    Attributes:
        east: Of its centre in ``map`` in [m].
        north: Of its centre in ``map`` in [m].
        up: Height in ``map`` in [m].
        radius: In [m], negative for counter-clockwise, seen from above.
    """

    east: float
    north: float
    up: float
    radius: float


DRIFT_TIME = 5.0  # s, in which the path angle comes back to that of the pitch
TICK = 0.01  # s: 100 Hz, above the 50 Hz at which ArduPlane runs its main loop by default


class Demand(NamedTuple):
    """What a mode asks of the inner loops.

    Attributes:
        roll: To the right in [rad].
        climb: u_chi in [rad/s].
        acceleration: u_v in [m/s^2].
    """

    roll: float
    climb: float
    acceleration: float


class Response(NamedTuple):
    """How the bank follows.

    Attributes:
        limit: Steepest bank in [rad].
        lag: Time constant in [s]: that of the plant's turn rate is part of it.
        rate: Greatest roll rate in [rad/s].
    """

    limit: float
    lag: float
    rate: float


class FlightLoops:
    """Flies an airframe.

    Args:
        airframe: What flies.
        simulator: Lags and limits of its plant.

    Attributes:
        throttle: From 0 to 1 [-].
        roll_wanted: Bank that the mode asks for, within its limit, in [rad].
    """

    def __init__(self, airframe: Airframe, simulator: SimulatorParameters) -> None:
        self._airframe = airframe
        self._steepest = simulator.pitch_rate_max
        self._plant_lag, self._path_lag, _ = simulator.rate_lag
        if simulator.roll_frequency:  # the turn swings in instead: the lag that it is alike
            self._plant_lag = 2.0 * simulator.roll_damping / simulator.roll_frequency
        self._path, self._pitched_at = 0.0, -math.inf  # what by_pitch holds, and since when not
        self._envelope = Envelope()  # that of a law, which only its climb and its clipping use
        self.throttle = 0.0
        self._bank = self.roll_wanted = airframe.state.roll

    def stand(self, running: bool) -> None:
        """Go on by one tick on the ground.

        Args:
            running: Whether it runs along its runway rather than stands.
        """
        self.throttle = float(running)
        self._bank = self.roll_wanted = 0.0
        self._airframe.stand(TICK, running)

    def fly(self, demand: Demand, response: Response, engine: Engine) -> None:
        """Go on by one tick in the air.

        Args:
            demand: Of the mode.
            response: Of the bank.
            engine: Tells which throttle it takes.
        """
        state = self._airframe.state
        limit, lag, rate = response
        limit = min(max(limit, 0.0), STEEPEST)  # no parameter allows more
        self.roll_wanted = min(max(demand.roll, -limit), limit)
        change = (self.roll_wanted - self._bank) / max(lag - self._plant_lag, TICK)
        self._bank += TICK * min(max(change, -rate), rate)
        climb = min(max(demand.climb, -self._steepest), self._steepest)
        # A coordinated turn; to the left u_psi is positive.
        turn = turn_rate_from_bank(self._bank, max(state.airspeed, 1.0))
        force = demand.acceleration + GRAVITY * math.sin(state.path_angle)
        self.throttle = engine.throttle(force, state.airspeed, state.roll)
        self._airframe.fly((turn, climb, demand.acceleration), TICK)

    def hold(self, up: float, airspeed: float, constants: HoldConstants) -> tuple[float, float]:
        """u_chi in [rad/s] and u_v in [m/s^2] that lead to an altitude and an airspeed.

        Args:
            up: Altitude to hold in ``map`` in [m].
            airspeed: To hold, true, in [m/s].
            constants: Of the energy control.
        """
        state = self._airframe.state
        return hold(
            up - state.up,
            state.up_rate,
            state.path_angle,
            state.airspeed,
            airspeed - state.airspeed,
            constants,
            math,
        )

    def by_pitch(self, pitch: float, lag: float) -> float:
        """u_chi in [rad/s] of a pitch that is held instead of an altitude.

        Args:
            pitch: Of the nose, up, in [rad].
            lag: Of the path angle behind the pitch in [s].
        """
        state = self._airframe.state
        if state.time - self._pitched_at > 1.5 * TICK:
            self._path = state.path_angle
        self._pitched_at = state.time
        incidence = self._airframe.incidence(state.airspeed, state.roll)
        # As with the bank: attitude loops of their own quickness, of which the plant is a part.
        rate = (pitch - incidence - self._path) / max(lag - self._path_lag, TICK)
        rate = min(max(rate, -self._steepest), self._steepest)
        self._path += TICK * rate
        return rate + (self._path - state.path_angle) / DRIFT_TIME

    def by_throttle(self, throttle: float, engine: Engine) -> float:
        """u_v in [m/s^2] of a throttle that is held instead of an airspeed.

        Args:
            throttle: From 0 to 1 [-].
            engine: What it drives.
        """
        state = self._airframe.state
        force = engine.force(throttle, state.airspeed, state.roll)
        return force - GRAVITY * math.sin(state.path_angle)

    def wings_level(self, lag: float, engine: Engine) -> Demand:
        """What a pilot does by sticks: no bank, the nose as the lift asks, the throttle at trim.

        Args:
            lag: Of the path angle behind the pitch in [s].
            engine: What the throttle drives.
        """
        state = self._airframe.state
        level = self._airframe.incidence(state.airspeed, state.roll)
        return Demand(0.0, self.by_pitch(level, lag), self.by_throttle(engine.trim, engine))

    def bank_to(self, loiter: Loiter, period: float, damping: float) -> float:
        """Bank to the right in [rad] that leads onto a circle, by :mod:`uav_tracking_mpc.laws.l1`.

        ArduPilot: ``AP_L1_Control::update_loiter`` and ``nav_roll_cd``. PX4 flies NPFG about a
        loiter (``FixedWingModeManager``); the simulated one flies this law there too.

        Args:
            loiter: The circle, whose centre stands.
            period: NAVL1_PERIOD in [s].
            damping: NAVL1_DAMPING [-].
        """
        state = self._airframe.state
        direction = CLOCKWISE if loiter.radius >= 0.0 else COUNTER_CLOCKWISE
        radius = min(max(abs(loiter.radius), LEAST_RADIUS), GREATEST_RADIUS)
        orbit = Orbit(radius, 0.0, max(state.airspeed, 1.0), direction)
        course = math.atan2(state.north_rate, state.east_rate)
        over_ground = [state.east, state.north, 0.0, course, 0.0, state.groundspeed]
        situation = Situation(
            vehicle=np.array(over_ground),
            target=np.array([loiter.east, loiter.north, 0.0]),
            drift=np.zeros(3),
            drift_rate=np.zeros(3),
            rates=np.zeros(3),
        )
        law = L1Loiter(
            orbit, self._envelope, max(period, LEAST_PERIOD), max(abs(damping), LEAST_DAMPING)
        )
        return float(bank_from_turn_rate(law.lateral_acceleration(situation), 1.0))  # v psi'
