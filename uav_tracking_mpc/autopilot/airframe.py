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

r"""The plant, with what a point that flies leaves out: attitude, the ground, and the take-off run.

A plant turns by (u_psi, u_chi, u_v). In a coordinated turn that is a bank to the right of

.. math:: \tan\phi = -\frac{V u_\psi}{g}

and the nose is above the path by the vertical part of the angle of attack that the lift asks for,
and beside it by the other part (:func:`~uav_tracking_mpc.estimation.flight_path.past_nose`),

.. math:: \theta - \chi = \alpha \cos\phi,\qquad \alpha = \frac{C_L - C_{L0}}{C_{L\alpha}},\qquad
          C_L = \frac{C_{L,c}}{\cos\phi} \left(\frac{V_c}{V}\right)^2

with the coefficients of the Aerosonde (R. W. Beard, T. W. McLain, "Small Unmanned Aircraft",
Princeton 2012, Table E.2, as the authors corrected it) at its cruise.

Throttle to specific force and back is that of an engine of which a pilot knows a few numbers.

At cruise V_c the trimmed throttle holds the airspeed in level flight, full throttle in a climb of
``w_+``, and no throttle in a sink of ``w_0``; both autopilots are told these numbers. The drag
grows with the square of the airspeed, and with the load factor n = 1 / cos(phi) of a turn by the
number R of TECS_RLL2THR and FW_T_RLL2THR:

.. math::

    u_v + g \sin\chi = \frac{g}{V_c}
        \begin{cases} w_+ \frac{\delta - \delta_t}{1 - \delta_t} & \delta \ge \delta_t \\
                      w_0 \frac{\delta - \delta_t}{\delta_t} & \delta < \delta_t \end{cases}
        - \frac{g w_0}{V_c} \left(\frac{V^2}{V_c^2} - 1\right) - \frac{R}{V_c} (n - 1)

the map from energy rate to throttle of PX4's TECS (``TECSControl::_calcThrottleControlOutput``).
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, heading_from_yaw
from uav_tracking_mpc.estimation.flight_path import past_nose
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.plants import Plant, plant_named

STEEPEST = math.radians(80.0)  # rad, bank up to which the load factor grows


def load_factor(roll: float) -> float:
    """Lift over weight of a coordinated turn [-].

    Args:
        roll: phi in [rad].
    """
    return 1.0 / math.cos(min(abs(roll), STEEPEST))


class Engine(NamedTuple):
    """An engine with its airframe.

    Attributes:
        cruise: V_c, true, in [m/s].
        trim: Throttle at cruise, from 0 to 1 [-].
        climb_max: ``w_+`` in [m/s].
        sink_idle: ``w_0`` in [m/s].
        load_energy: R in [m^2/s^3].
    """

    cruise: float
    trim: float
    climb_max: float
    sink_idle: float
    load_energy: float

    def force(self, throttle: float, airspeed: float, roll: float) -> float:
        """u_v + g sin(chi) in [m/s^2].

        Args:
            throttle: delta from 0 to 1 [-].
            airspeed: V, true, in [m/s].
            roll: phi in [rad].
        """
        above = min(max(throttle, 0.0), 1.0) - self.trim
        climb = (
            self.climb_max * above / (1.0 - self.trim)
            if above >= 0.0
            else self.sink_idle * above / self.trim
        )
        return GRAVITY / self.cruise * (climb - self._drag(airspeed, roll))

    def throttle(self, force: float, airspeed: float, roll: float) -> float:
        """Throttle from 0 to 1 [-] that gives a force, as nearly as it can.

        Args:
            force: u_v + g sin(chi) in [m/s^2].
            airspeed: V, true, in [m/s].
            roll: phi in [rad].
        """
        climb = force * self.cruise / GRAVITY + self._drag(airspeed, roll)
        share = climb / self.climb_max if climb >= 0.0 else climb / self.sink_idle
        room = 1.0 - self.trim if climb >= 0.0 else self.trim
        return min(max(self.trim + share * room, 0.0), 1.0)

    def _drag(self, airspeed: float, roll: float) -> float:
        """Sink that the drag beyond that of level cruise makes in [m/s]."""
        faster = self.sink_idle * ((airspeed / self.cruise) ** 2 - 1.0)
        return faster + self.load_energy / GRAVITY * (load_factor(roll) - 1.0)


LIFT_AT_ZERO, LIFT_SLOPE, CRUISE_LIFT = 0.23, 5.61, 0.5  # -, 1/rad, -: C_L0, C_L_alpha, cruise
STALL = 0.25  # rad, beyond which no angle of attack is told
WIND_MEMORY = 5.0  # s, over which the estimator averages the wind
RUN_ACCELERATION = 4.0  # m/s^2 along the runway
ROTATION = 1.2  # -, of the least airspeed: where it leaves the ground
BODY_RATES = ("roll_rate", "pitch_rate", "yaw_rate")


class FlightState(NamedTuple):
    """What sensors and estimator of the autopilot say at one time.

    Attributes:
        time: Since the start in [s].
        east: Position in ``map`` in [m].
        north: Position in ``map`` in [m].
        up: Position in ``map`` in [m].
        east_rate: Ground velocity in [m/s].
        north_rate: Ground velocity in [m/s].
        up_rate: Ground velocity in [m/s].
        airspeed: True, in [m/s].
        heading: psi of the air velocity, counter-clockwise from East of ``map``, in [rad].
        path_angle: Of the air velocity in [rad].
        turn_rate: psi' in [rad/s].
        roll: To the right in [rad].
        pitch: Of the nose, up, in [rad].
        roll_rate: About the body's forward axis in [rad/s].
        pitch_rate: About its right axis in [rad/s].
        yaw_rate: About its axis down in [rad/s].
    """

    time: float
    east: float
    north: float
    up: float
    east_rate: float
    north_rate: float
    up_rate: float
    airspeed: float
    heading: float
    path_angle: float
    turn_rate: float
    roll: float
    pitch: float
    roll_rate: float = 0.0
    pitch_rate: float = 0.0
    yaw_rate: float = 0.0

    @property
    def place(self) -> tuple[float, float, float]:
        """Position in ``map`` in [m]."""
        return self.east, self.north, self.up

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Ground velocity in ``map`` in [m/s]."""
        return self.east_rate, self.north_rate, self.up_rate

    @property
    def groundspeed(self) -> float:
        """Horizontal speed over ground in [m/s]."""
        return math.hypot(self.east_rate, self.north_rate)

    @property
    def yaw(self) -> float:
        """Heading of the nose, clockwise from North, in [rad], from -pi to pi."""
        return heading_from_yaw(self.heading - past_nose(self.roll, self.pitch, self.path_angle))


class Airframe:
    """An aircraft that stands, runs along its runway, or flies as its plant does.

    Args:
        configuration: Its section ``uav_simulator`` has the plant, the air and the start, its
            section ``nmpc_controller`` the cruise.
        on_runway: It stands below the start, heading as at the start.

    Attributes:
        plant: What flies; None on the ground.
        time: Since the start in [s].
        flying: Whether it is in the air.
        state: As loops and failsafes see it.
        wind: East, north and up of the wind as it is estimated, in [m/s].
    """

    def __init__(self, configuration: Configuration, on_runway: bool = False) -> None:
        self._configuration = configuration
        self._cruise = configuration.controller.airspeed
        simulator = configuration.simulator
        self.time, self._began = 0.0, 0.0
        self.plant: Plant | None = None
        self._run = 0.0  # speed along the runway in m/s
        self._east, self._north, _ = simulator.initial_position
        self._heading = simulator.initial_heading
        self.wind = np.array(simulator.wind, dtype=float)
        slowest = max(simulator.speed_min, configuration.controller.airspeed_min)
        self._rotation = min(ROTATION * max(slowest, 1.0), simulator.speed_max)
        if not on_runway:
            self.plant = plant_named(simulator.plant).of(configuration)
        self._measured: FlightState | None
        self.state = self._measured = self._standing()
        if self.plant is not None:
            self.state = self._measured = self._seen(self.plant.truth, None, 1.0)

    @property
    def flying(self) -> bool:
        """Whether it is in the air."""
        return self.plant is not None

    @property
    def measured(self) -> FlightState:
        """State as telemetry tells it: with noise, biases and delay of the sensors."""
        if self._measured is None:
            assert self.plant is not None, "on the ground there are no errors"
            rates = {name: getattr(self.state, name) for name in BODY_RATES}
            self._measured = self._seen(self.plant.measured(), None, 0.0)._replace(**rates)
        return self._measured

    def stand(self, duration: float, running: bool) -> None:
        """Let time go on on the ground.

        Args:
            duration: How long in [s].
            running: Whether it runs along the runway under full power, until it flies.
        """
        self.time += duration
        self._run = self._run + RUN_ACCELERATION * duration if running else 0.0
        self._east += self._run * duration * math.cos(self._heading)
        self._north += self._run * duration * math.sin(self._heading)
        self.state = self._measured = self._standing()
        if running and self.state.airspeed >= self._rotation:
            simulator = dataclasses.replace(
                self._configuration.simulator,
                initial_position=(self._east, self._north, 0.1),
                initial_heading=math.remainder(self._heading, 2.0 * math.pi),
                initial_path_angle=0.0,
                initial_speed=self.state.airspeed,
            )
            changed = dataclasses.replace(self._configuration, simulator=simulator)
            self.plant, self._began = plant_named(simulator.plant).of(changed), self.time

    def fly(self, inputs: tuple[float, float, float], duration: float) -> None:
        """Fly on in the air; where it comes to the ground it stays.

        Args:
            inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s], [rad/s] and [m/s^2].
            duration: How long in [s].
        """
        assert self.plant is not None, "it stands on the ground"
        self.plant.accept([inputs], [self.plant.time])
        self.plant.advance(duration)
        self.time += duration
        self.state = self._seen(self.plant.truth, self.state, duration)
        self._measured = None
        self.wind = self.wind + duration / WIND_MEMORY * (self.plant.wind - self.wind)
        if self.state.up <= 0.0:
            _, self._east, self._north, *_ = self.state
            self._heading, self.plant = self.state.heading, None
            self.stand(0.0, running=False)

    def incidence(self, airspeed: float, roll: float) -> float:
        """By how much the nose is above the path in [rad].

        Args:
            airspeed: V in [m/s].
            roll: phi in [rad].
        """
        lift = CRUISE_LIFT / max(math.cos(roll), 0.2) * (self._cruise / max(airspeed, 0.1)) ** 2
        return min(max((lift - LIFT_AT_ZERO) / LIFT_SLOPE, -STALL), STALL) * math.cos(roll)

    def _standing(self) -> FlightState:
        along, across = math.cos(self._heading), math.sin(self._heading)
        tailwind = float(self.wind[0] * along + self.wind[1] * across)
        place, velocity = (self._east, self._north, 0.0), (self._run * along, self._run * across)
        airspeed, level = max(self._run - tailwind, 0.0), (0.0, 0.0, 0.0, 0.0)
        return FlightState(self.time, *place, *velocity, 0.0, airspeed, self._heading, *level)

    def _seen(
        self, measured: Measurement, before: FlightState | None, duration: float
    ) -> FlightState:
        """State of a measurement, with the body's rates from the attitude before."""
        airspeed, turn_rate = measured.airspeed or 0.0, measured.turn_rate
        roll = bank_from_turn_rate(turn_rate, airspeed)
        pitch = measured.path_angle + self.incidence(airspeed, roll)
        east, north, up = measured.position.tolist()
        east_rate, north_rate, up_rate = measured.ground_velocity.tolist()
        place, velocity = (east, north, up), (east_rate, north_rate, up_rate)
        direction = measured.heading, measured.path_angle
        time = self._began + measured.stamp
        state = FlightState(time, *place, *velocity, airspeed, *direction, turn_rate, roll, pitch)
        if before is None or duration <= 0.0:
            return state
        # Euler angles' rates to the body's axes, forward, right, down.
        roll_rate = (roll - before.roll) / duration
        pitch_rate = (pitch - before.pitch) / duration
        yaw_rate = math.remainder(state.yaw - before.yaw, math.tau) / duration
        sine, cosine = math.sin(roll), math.cos(roll)
        return state._replace(
            roll_rate=roll_rate - yaw_rate * math.sin(pitch),
            pitch_rate=pitch_rate * cosine + yaw_rate * sine * math.cos(pitch),
            yaw_rate=-pitch_rate * sine + yaw_rate * cosine * math.cos(pitch),
        )
