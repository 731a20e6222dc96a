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

r"""Six degrees of freedom: JSBSim's equations of motion behind an autopilot's inner loops.

Its sensors tell position, ground velocity and airspeed, and attitude and rates of the body: the
path is found from them by :mod:`~uav_tracking_mpc.estimation.flight_path`. The truth is the motion
of a point mass that does not slip: the heading past the nose, the turn rate of the bank, and with
the path angle :math:`\chi = \arcsin(\dot z / v)`

.. math:: \dot\chi = (a_L \cos\phi - g \cos\chi) / v,

where :math:`a_L` is the specific force upwards in the body.

The inner loops of its autopilot hold bank, path angle and airspeed by servos. From the inputs of a
plan come three demands,

.. math::

    \phi_d = -\arctan\frac{v \cos\chi\, u_\psi}{g},\qquad \dot\chi_d = u_\chi,\qquad
    \dot v_d = u_v,

and from these rates of roll and pitch and a thrust, held by proportional and integral feedback with
feed-forward, as ArduPlane and PX4 have them (APM_Control and TECS; fw_rate_control), gains falling
with the dynamic pressure. The rudder damps the yaw and takes the side force out. Axes are those of
autopilots: forward, right, down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import (
    bank_from_turn_rate,
    course_rates_from_euler,
    turn_rate_from_bank,
)
from uav_tracking_mpc.estimation.flight_path import past_nose
from uav_tracking_mpc.estimation.measurement import Axis, Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.flight_dynamics import (
    RATE,
    Airframe,
    AirframeError,
    Flown,
    Surfaces,
)
from uav_tracking_mpc.simulation.plants import AIR, Plant, SimulationError

SPEED = 22.0  # m/s, at which the gains are tuned

# Roll: what a bank error becomes, and the aileron for a roll rate.
BANK_TIME = 0.35  # s
ROLL_RATE_MAX = 1.2  # rad/s
ROLL_FORWARD = 0.2  # rad per rad/s
YAW_TO_ROLL = -0.097  # rad per rad/s: the outer wing lifts more
ROLL_GAIN = 0.15  # rad per rad/s
ROLL_INTEGRAL = 0.2  # rad per rad

# Pitch: what a path-angle error becomes, and the elevator for a lift.
PATH_TIME = 0.8  # s
PATH_LAG = 0.2  # s, with which the path angle follows at best
LIFT_MIN, LIFT_MAX = 0.0, 1.9 * GRAVITY  # m/s^2
LIFT_FORWARD = 0.035  # rad per m/s^2
PITCH_FORWARD = 0.167  # rad per rad/s
PITCH_GAIN = 0.2  # rad per rad/s
PITCH_INTEGRAL = 0.6  # rad per rad

# Yaw: damping about the yaw rate of the turn, side force, what ailerons and roll rate yaw.
ALPHA_ZERO, ALPHA_LIFT = -0.041, 0.0126  # rad, rad per m/s^2: angle of attack at a lift
YAW_GAIN = 0.3  # rad per rad/s
SIDE_GAIN = 0.03  # rad per m/s^2
SIDE_INTEGRAL = 0.05  # rad per m/s
AILERON_TO_RUDDER = -0.16  # rad per rad
ROLL_TO_RUDDER = -0.09  # rad per rad/s

# Throttle: what a speed error becomes, and the throttle for a specific force.
SPEED_TIME = 1.2  # s
FORCE_FORWARD = 0.105  # 1 per m/s^2
SPEED_FORWARD = 0.023  # 1 per m/s
SPEED_INTEGRAL = 0.03  # 1 per m
INDUCED_DRAG = 0.15  # m/s^2 in level flight at SPEED
AILERON_MAX = ELEVATOR_MAX = RUDDER_MAX = 0.7854  # rad
LEVELLING_TIME = 1.0  # s, in which the demanded path angle is taken out where no plan is left


class FlightControl:
    """Holds the demands and the integrals.

    Args:
        parameters: Limits of bank, rates, acceleration and airspeed.
        trim: Surfaces of the steady flight in which it begins.
        flown: What is measured there.

    Attributes:
        bank_demand: Positive to the right, in [rad].
        path_demand: chi_d in [rad].
        speed_demand: v_d in [m/s].
    """

    def __init__(self, parameters: SimulatorParameters, trim: Surfaces, flown: Flown) -> None:
        self._limits = parameters
        self.bank_demand = 0.0
        self.path_demand, self.speed_demand = flown.path_angle, flown.airspeed
        stiffness = (flown.airspeed / SPEED) ** 2
        self._roll = trim.aileron * stiffness
        climb = GRAVITY * math.sin(self.path_demand)
        lift = GRAVITY * math.cos(self.path_demand)
        self._pitch = trim.elevator + LIFT_FORWARD / stiffness * lift
        self._yaw = (trim.rudder - AILERON_TO_RUDDER * trim.aileron) * stiffness
        self._thrust = trim.throttle - self._force_throttle(flown, climb)
        self._climb = 0.0  # rate in rad/s at which the demanded path angle changes
        self._full = 0  # of the throttle: at its upper end 1, at its lower -1
        self._lift_full = 0  # of the lift, likewise

    def surfaces(self, inputs: Sequence[float] | None, flown: Flown, step: float) -> Surfaces:
        """What the servos are told.

        Args:
            inputs: (u_psi, u_chi, u_v) of the plan in [rad/s], [rad/s] and [m/s^2]; None where
                no plan is left: wings level, climb taken out, airspeed held.
            flown: What is measured.
            step: Time until it is asked again in [s].
        """
        if inputs is None:
            inputs = 0.0, -self.path_demand / LEVELLING_TIME, 0.0
        turn, climb, gain = self._limited(inputs)
        weaker = (SPEED / flown.airspeed) ** 2
        aileron = self._aileron(turn, flown, weaker, step)
        return Surfaces(
            aileron,
            self._elevator(climb, flown, weaker, step),
            self._rudder(aileron, flown, weaker, step),
            self._throttle(gain, flown, step),
        )

    def _limited(self, inputs: Sequence[float]) -> tuple[float, float, float]:
        limits = self._limits
        turn, climb, gain = inputs
        return (
            _clip(turn, limits.yaw_rate_max),
            _clip(climb, limits.pitch_rate_max),
            min(max(gain, limits.acceleration_min), limits.acceleration_max),
        )

    def _aileron(self, turn: float, flown: Flown, weaker: float, step: float) -> float:
        self.bank_demand = _clip(bank_from_turn_rate(turn, flown.airspeed), self._limits.bank_max)
        wanted = _clip((self.bank_demand - flown.bank) / BANK_TIME, ROLL_RATE_MAX)
        # p = phi' - psi' sin(theta), psi' = g tan(phi) / v
        wanted -= GRAVITY / flown.airspeed * math.tan(flown.bank) * math.sin(flown.pitch)
        error = wanted - flown.roll_rate
        forward = ROLL_FORWARD * wanted + YAW_TO_ROLL * flown.yaw_rate
        forward *= SPEED / flown.airspeed
        aileron = forward + weaker * (ROLL_GAIN * error + self._roll)
        if abs(aileron) < AILERON_MAX or aileron * error < 0.0:
            self._roll += step * ROLL_INTEGRAL * error
        return _clip(aileron, AILERON_MAX)

    def _elevator(self, climb: float, flown: Flown, weaker: float, step: float) -> float:
        self._climb += step / PATH_LAG * (climb - self._climb)
        demand = self.path_demand + step * self._climb
        self.path_demand = _held(self.path_demand, demand, flown.path_angle, self._lift_full)
        rate = climb + (self.path_demand - flown.path_angle) / PATH_TIME
        cos_bank = math.cos(flown.bank)
        weight = GRAVITY * math.cos(flown.path_angle)
        # m v chi' = L cos(bank) - m g cos(chi)
        asked = (flown.airspeed * rate + weight) / max(cos_bank, 0.3)
        lift = min(max(asked, LIFT_MIN), LIFT_MAX)
        self._lift_full = (asked > LIFT_MAX) - (asked < LIFT_MIN)
        wanted = (lift - weight * cos_bank) / flown.airspeed
        error = wanted - flown.pitch_rate
        forward = weaker * LIFT_FORWARD * lift + PITCH_FORWARD * SPEED / flown.airspeed * wanted
        elevator = self._pitch - forward - weaker * PITCH_GAIN * error
        if abs(elevator) < ELEVATOR_MAX or elevator * error > 0.0:
            self._pitch -= step * weaker * PITCH_INTEGRAL * error
        return _clip(elevator, ELEVATOR_MAX)

    def _rudder(self, aileron: float, flown: Flown, weaker: float, step: float) -> float:
        turning = GRAVITY / flown.airspeed * math.sin(flown.bank) * math.cos(flown.pitch)
        # About the velocity, not the nose: else the angle of attack becomes sideslip.
        alpha = ALPHA_ZERO + ALPHA_LIFT * flown.lift * weaker
        turning += alpha * flown.roll_rate
        damping = YAW_GAIN * (flown.yaw_rate - turning) + SIDE_GAIN * flown.side_force
        mixed = ROLL_TO_RUDDER * SPEED / flown.airspeed * flown.roll_rate
        rudder = AILERON_TO_RUDDER * aileron + mixed + weaker * (damping + self._yaw)
        if abs(rudder) < RUDDER_MAX or rudder * flown.side_force < 0.0:
            self._yaw += step * SIDE_INTEGRAL * flown.side_force
        return _clip(rudder, RUDDER_MAX)

    def _throttle(self, gain: float, flown: Flown, step: float) -> float:
        limits = self._limits
        demand = self.speed_demand + step * gain
        demand = _held(self.speed_demand, demand, flown.airspeed, self._full)
        self.speed_demand = min(max(demand, limits.speed_min), limits.speed_max)
        if (demand - self.speed_demand) * gain > 0.0:
            gain = 0.0
        error = self.speed_demand - flown.airspeed
        force = gain + error / SPEED_TIME + GRAVITY * math.sin(flown.path_angle)
        throttle = self._force_throttle(flown, force) + self._thrust
        self._full = (throttle > 1.0) - (throttle < 0.0)
        if error * self._full <= 0.0:
            self._thrust += step * SPEED_INTEGRAL * error
        return min(max(throttle, 0.0), 1.0)

    def _force_throttle(self, flown: Flown, force: float) -> float:
        """Throttle for a specific force [m/s^2] along the path, but for a constant."""
        loads = (flown.lift / GRAVITY) ** 2
        drag = INDUCED_DRAG * loads * (SPEED / flown.airspeed) ** 2
        return FORCE_FORWARD * (force + drag) + SPEED_FORWARD * flown.airspeed


def _held(before: float, after: float, flown: float, full: int) -> float:
    """A demand that grows no further than what is flown where the actuator is at its end."""
    if full * (after - before) <= 0.0:
        return after
    return max(before, min(after, flown)) if full > 0 else min(before, max(after, flown))


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


class JSBSimPlant(Plant):
    """The airframe of :mod:`~uav_tracking_mpc.simulation.flight_dynamics`, trimmed where it starts.

    Lag and dead time are what servos, inner loops and airframe make of them, not parameters.

    Args:
        parameters: Start, limits, air and sensors.

    Attributes:
        airframe: The aircraft.
        control: Its inner loops.

    Raises:
        SimulationError: There is no steady flight to start from.
        ImportError: JSBSim is not installed.
    """

    name = "jsbsim"
    changeable = AIR

    def __init__(self, parameters: SimulatorParameters) -> None:
        super().__init__(parameters)
        air, _ = np.random.SeedSequence(parameters.seed).spawn(2)  # the other is the sensors'
        try:
            self.airframe = Airframe(parameters, int(air.generate_state(1)[0]) % 2**31)
        except AirframeError as error:
            raise SimulationError(str(error)) from error
        self.control = FlightControl(parameters, self.airframe.trim, self.airframe.flown)

    @property
    def wind(self) -> NDArray[np.float64]:
        """See :meth:`Plant.wind`."""
        return self.airframe.wind

    @property
    def truth(self) -> Measurement:
        """See :meth:`Plant.truth`."""
        flown = self.airframe.flown
        weight = GRAVITY * math.cos(flown.path_angle)
        past = past_nose(flown.bank, flown.pitch, flown.path_angle)
        return replace(
            self.aboard,
            heading=math.remainder(self.airframe.yaw + past, 2.0 * math.pi),
            path_angle=flown.path_angle,
            turn_rate=turn_rate_from_bank(flown.bank, flown.airspeed),
            path_angle_rate=(flown.lift * math.cos(flown.bank) - weight) / flown.airspeed,
            axis=Axis.AIR_VELOCITY,
        )

    @property
    def aboard(self) -> Measurement:
        """See :meth:`Plant.aboard`."""
        airframe = self.airframe
        flown, velocity = airframe.flown, airframe.ground_velocity
        rates = flown.roll_rate, flown.pitch_rate, flown.yaw_rate
        turn_rate, elevation_rate = course_rates_from_euler(flown.bank, flown.pitch, rates)
        # A stamp between two steps: at most half a step from the nearer one.
        ahead = self.time - airframe.steps / RATE
        return Measurement(
            stamp=self.time,
            position=airframe.position + ahead * velocity,
            ground_velocity=velocity,
            heading=airframe.yaw,
            path_angle=flown.pitch,
            turn_rate=turn_rate,
            path_angle_rate=elevation_rate,
            airspeed=flown.airspeed,
            bank=flown.bank,
        )

    def change(self, parameters: SimulatorParameters) -> None:
        """See :meth:`Plant.change`."""
        super().change(parameters)
        self.airframe.blow(parameters.wind, parameters.gust_intensity)

    def advance(self, duration: float) -> None:
        """See :meth:`Plant.advance`."""
        if duration <= 0.0:
            return
        end = self.time + duration
        for _ in range(round(end * RATE) - self.airframe.steps):
            self._step()
        self.time = end

    def _step(self) -> None:
        now = self.airframe.steps / RATE
        plan = self.plan.inputs(now)
        inputs = None if plan is None else (plan * self.parameters.command_gain).tolist()
        surfaces = self.control.surfaces(inputs, self.airframe.flown, 1.0 / RATE)
        try:
            self.airframe.step(surfaces)
        except AirframeError as error:
            raise SimulationError(f"at {now:.4g} s {error}") from error
        if self.airframe.height < 0.0:
            raise SimulationError(f"at {now:.4g} s the aircraft hits the ground")
