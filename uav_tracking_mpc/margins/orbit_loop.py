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

r"""The controller's loop near its orbit, linearised at one azimuth.

In a still air the motion relative to the target, seen in axes that turn with the azimuth phi, does
not depend on time. A drift c makes it periodic; frozen at an azimuth it is time-invariant again.
The deviation from the orbit at the same azimuth has the components of :class:`Deviation`. With
:math:`\beta = \psi - \phi` and :math:`V = v \cos\chi`,

.. math::

    \dot d = V \cos\beta + c_r, \quad d \dot\phi = V \sin\beta + c_t, \quad
    \dot z = v \sin\chi + c_z, \quad \dot\beta = \omega_\psi - \dot\phi,

and each rate follows its command with a lag, :math:`\tau \dot\omega = u - \omega`. The deviation
:math:`\delta = x - x^*(\phi)` then moves with :math:`\dot x - (dx^*/d\phi)\,\dot\phi`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.control.guidance import compile_flight, formulation_of, law_about, law_of
from uav_tracking_mpc.dynamics.orbit import Orbit, orbit_motion
from uav_tracking_mpc.dynamics.vehicle import Response, followed
from uav_tracking_mpc.estimation.navigator import LONGEST_SUBSTEP, ROUNDING
from uav_tracking_mpc.estimation.situation import Situation, steady_forecast
from uav_tracking_mpc.margins.loop_margins import UNSTABLE, LoopMargins, loop_margins
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.symbolic.functions import one_at_a_time

SLOPE_STEP = 1e-4  # rad of azimuth
COMPLEX_STEP = 1e-20  # -, tolerance: no digit of a derivative is lost, however small it is
SHORTEST_LAG = 1e-3  # s: a channel that follows at once is given this lag


class Deviation(NamedTuple):
    """Components of the motion near an orbit, and how far each is moved for a difference.

    Attributes:
        distance: Horizontal, to the target, in [m].
        height: Above the target in [m].
        course: Heading less azimuth in [rad].
        path_angle: chi in [rad].
        airspeed: v in [m/s].
        turn_rate: psi' in [rad/s].
        path_angle_rate: chi' in [rad/s].
        acceleration: v' in [m/s^2].
    """

    distance: float = 0.1
    height: float = 0.05
    course: float = 1e-3
    path_angle: float = 1e-3
    airspeed: float = 0.02
    turn_rate: float = 1e-3
    path_angle_rate: float = 1e-3
    acceleration: float = 0.02


STEPS = np.array(Deviation())
ACCELERATION = Deviation._fields.index("acceleration")
RATES = slice(ACCELERATION - 2, ACCELERATION + 1)
SIZE = len(STEPS)


@dataclass(frozen=True)
class FrozenOrbit:
    """An orbit in a steady drift at one azimuth.

    Attributes:
        orbit: What is flown.
        drift: c in the axes of ``map``, shape (3,), in [m/s].
        azimuth: phi in [rad], direction from target to aircraft.
    """

    orbit: Orbit
    drift: NDArray[np.float64]
    azimuth: float

    @one_at_a_time
    def motion(self, azimuth: float | None = None) -> NDArray[np.float64]:
        """The orbit's own :class:`Deviation` components at an azimuth, shape (8,).

        Args:
            azimuth: In [rad]; that of this object by default.
        """
        phi = self.azimuth if azimuth is None else azimuth
        orbit = self.orbit
        there = orbit_motion(
            (ca.SX(math.cos(phi)), ca.SX(math.sin(phi))), ca.SX(orbit.sense), ca.SX(orbit.radius),
            ca.SX(orbit.speed), ca.SX(self.drift), ca.SX.zeros(3),
        )  # fmt: skip
        speed, turn_rate = float(there.relative_speed), float(there.turn_rate)
        east, north = (speed * float(part) for part in there.tangent)
        heading = math.atan2(north - self.drift[1], east - self.drift[0])
        course = math.remainder(heading - phi, 2.0 * math.pi)
        radius, height = orbit.radius, orbit.altitude
        climb = float(there.path_angle)
        return np.array([radius, height, course, climb, orbit.speed, turn_rate, 0.0, 0.0])

    def situation(self, deviation: NDArray[np.float64]) -> Situation:
        """Situation at a deviation from the orbit; the target is at the origin of ``map``.

        Args:
            deviation: :class:`Deviation`, shape (8,).
        """
        distance, height, course, climb, speed, *rates = self.motion() + deviation
        x, y = distance * math.cos(self.azimuth), distance * math.sin(self.azimuth)
        vehicle = np.array([x, y, height, course + self.azimuth, climb, speed])
        return Situation(vehicle, np.zeros(3), self.drift, np.zeros(3), np.array(rates))

    def dynamics(self, lags: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A and B of the deviation's motion, shapes (8, 8) and (8, 3), in SI units.

        Args:
            lags: tau of the three channels, shape (3,), in [s].
        """
        tau = np.maximum(np.asarray(lags, dtype=float), SHORTEST_LAG)
        ahead, behind = (self.azimuth + step for step in (SLOPE_STEP, -SLOPE_STEP))
        slope = (self.motion(ahead) - self.motion(behind)) / (2.0 * SLOPE_STEP)
        cosine, sine = math.cos(self.azimuth), math.sin(self.azimuth)
        c_r = self.drift[0] * cosine + self.drift[1] * sine
        c_t = self.drift[1] * cosine - self.drift[0] * sine

        def rate(state: NDArray[Any]) -> NDArray[Any]:
            d, _, course, climb, v, turn, climbing, gain = state
            level = v * np.cos(climb)
            turning = (level * np.sin(course) + c_t) / d
            rates = np.array([turn, climbing, gain])
            motion = [
                level * np.cos(course) + c_r,
                v * np.sin(climb) + self.drift[2],
                turn - turning, climbing, gain,
            ]  # fmt: skip
            return np.concatenate([motion, -rates / tau]) - slope * turning

        here, b = self.motion(), np.zeros((SIZE, 3))
        b[RATES] = np.diag(1.0 / tau)
        return jacobian(rate, here), b


def jacobian(
    function: Callable[[NDArray[Any]], NDArray[Any]], point: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Derivative of an analytic function by complex steps, shape (m, n).

    Args:
        function: Of shape (n,) to shape (m,).
        point: Where, in its own units, shape (n,).
    """
    columns = [function(point + 1j * COMPLEX_STEP * unit).imag for unit in np.eye(len(point))]
    return np.array(columns).T / COMPLEX_STEP


SOLVE_TIME_MAX = 10.0  # s: nothing flies on these solves
# rad/s, rad/s, m/s^2: of the inputs on the orbit off its own motion; beyond them it is left.
STEADY = np.array([0.02, 0.02, 0.1])
FREQUENCIES = 400  # frequencies of a response: its margins are then within 1 % of those of 4000


class OrbitLoop:
    r"""Loops of one set of parameters, with a solver of its own.

    Near a steady orbit the guidance is a static gain :math:`-K` of the situation in which its
    command takes effect, here by central differences of its own answers. Around it lie the aircraft
    and the prediction. Estimators that are exact while all sensors are, such as those of wind and
    target, do not show; nor does the time that a solve takes.

    Args:
        parameters: What is flown.

    Raises:
        ParameterError: There is no such law, or the parameters cannot be flown.
    """

    def __init__(self, parameters: TrackingParameters) -> None:
        compile_flight(parameters)  # before, for what builds a formulation makes others wait for it
        self._formulation = formulation_of(parameters)
        self.change(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Use other parameters from now on, of which no fixed one differs.

        Args:
            parameters: The new ones.
        """
        self.parameters, law = parameters, law_of(parameters)
        self._law = None if law is None else law_about(law, parameters.orbit, parameters)
        self.told, self._predicted = parameters.response, parameters.flown_by(parameters.response)
        if self._formulation is not None:
            unhurried = replace(parameters, solve_time_max=SOLVE_TIME_MAX)
            self._formulation.change(unhurried)

    def orbit_in(self, drift: NDArray[np.float64], azimuth: float = 0.0) -> FrozenOrbit:
        """The orbit that is asked for, in a steady drift at one azimuth.

        Args:
            drift: c in the axes of ``map``, shape (3,), in [m/s].
            azimuth: phi in [rad].
        """
        return FrozenOrbit(self.parameters.orbit, drift, azimuth)

    def gain(self, frozen: FrozenOrbit) -> NDArray[np.float64]:
        """Effect of a deviation on the command, shape (3, 8), in SI units.

        Args:
            frozen: Where.

        Raises:
            ParameterError: The guidance has no answer there, or none that stays on the orbit.
        """
        if self._formulation is not None:
            self._formulation.reset()
        off = self._answer(frozen.situation(np.zeros(SIZE)), None) - frozen.motion()[-3:]
        if not (np.abs(off) <= STEADY).all():
            raise ParameterError("the orbit that is asked for is left: limits or the law lead away")
        gain = np.zeros((3, SIZE))
        for component, deviation in enumerate(np.diag(STEPS)):
            above = self._answer(frozen.situation(deviation), 0.0)
            below = self._answer(frozen.situation(-deviation), 0.0)
            gain[:, component] = (above - below) / (2.0 * STEPS[component])
        return gain

    def _answer(self, situation: Situation, elapsed: float | None) -> NDArray[np.float64]:
        if self._law is not None:
            return np.asarray(self._law.inputs(situation), dtype=float)
        assert self._formulation is not None
        ahead = steady_forecast(situation, self.parameters.horizon)
        orbit = self.parameters.orbit
        plan = self._formulation.solve(situation, ahead, orbit, elapsed)
        if not plan.solution.converged:
            drift = float(np.linalg.norm(situation.drift))
            raise ParameterError(
                f"no plan holds the orbit in a drift of {drift:.3g} m/s: {plan.solution.message}"
            )
        return plan.inputs[0]

    def loop(self, frozen: FrozenOrbit, plant: Response | None = None) -> SampledLoop:
        """The sampled loop near an orbit.

        Args:
            frozen: Where.
            plant: How the aircraft responds; as the controller is told by default.

        Raises:
            ParameterError: The guidance has no answer there.
        """
        plant, period = plant or self.told, 1.0 / self.parameters.control_rate
        predicted = None if self._formulation is None else frozen.dynamics(self._predicted.lags)
        true = frozen.dynamics(plant.lags)
        return sampled_loop(period, self.gain(frozen), true, plant, predicted, self._predicted)

    def margins(self, frozen: FrozenOrbit, plant: Response | None = None) -> LoopMargins:
        """Margins of the sampled loop near an orbit; all 0 where it is not stable.

        Args:
            frozen: Where.
            plant: How the aircraft responds; as the controller is told by default.

        Raises:
            ParameterError: The guidance has no answer there.
        """
        loop = self.loop(frozen, plant)
        if not loop.growth() < 1.0:
            return UNSTABLE
        frequency = loop.frequencies(FREQUENCIES)
        return loop_margins(frequency, loop.response(frequency))


SLOWEST = 1e-2  # rad/s, the lowest frequency of a response


@dataclass(frozen=True)
class SampledLoop:
    r"""The sampled loop near the orbit: lag, dead time, prediction and a static gain.

    Every T seconds the controller measures the deviation :math:`\delta_k`, predicts it to when the
    new command takes effect, through the commands that are under way, and answers
    :math:`u_k = -K \hat\delta_k`. The plant holds :math:`u_k` for T, a dead time later. A dead
    time :math:`\theta = l T + f` that is no multiple of T is exact (Franklin, Powell, Workman,
    "Digital control of dynamic systems", 3rd ed., section 4.3.4):

    .. math::

        \delta_{k+1} = e^{AT} \delta_k + \Gamma_a u_{k-l-1} + \Gamma_b u_{k-l}, \quad
        \Gamma_a = e^{A(T-f)} \int_0^f e^{As} ds\, B, \quad
        \Gamma_b = \int_0^{T-f} e^{As} ds\, B.

    Attributes:
        period: T in [s].
        plant_step: e^(AT) of the aircraft, shape (8, 8).
        plant_taps: Effect of the plant's input of 0, 1, ... periods before, shape (n, 8, 3).
        state_gain: Effect of the measured deviation on the command, shape (3, 8).
        command_taps: Effect of the commands of 0, 1, ... periods before, shape (m, 3, 3); that of
            0 periods before is zero.
        acceleration_gain: Effect of the acceleration that the controller works out from its
            commands, shape (3,).
        acceleration_share: Of the difference between that acceleration and the command, by which it
            follows in a period [-].
        acceleration_tap: Periods between that command and the present one [-].
    """

    period: float
    plant_step: NDArray[np.float64]
    plant_taps: NDArray[np.float64]
    state_gain: NDArray[np.float64]
    command_taps: NDArray[np.float64]
    acceleration_gain: NDArray[np.float64]
    acceleration_share: float
    acceleration_tap: int

    def frequencies(self, count: int) -> NDArray[np.float64]:
        """Up to the Nyquist frequency, evenly on a logarithmic scale, shape (n,), in [rad/s].

        Args:
            count: n.
        """
        return np.geomspace(SLOWEST, math.pi / self.period, count)

    def response(self, frequency: NDArray[np.float64]) -> NDArray[Any]:
        """L at the plant's input, shape (n, 3, 3), for negative feedback.

        Args:
            frequency: Shape (n,), in [rad/s].
        """
        z = np.exp(1j * frequency * self.period)[:, np.newaxis, np.newaxis]
        plant = np.linalg.solve(z * np.eye(SIZE) - self.plant_step, _sum(self.plant_taps, z))
        own = _sum(self.command_taps, z)
        follows = self.acceleration_share * z**-self.acceleration_tap
        follows = follows / (1.0 - (1.0 - self.acceleration_share) / z)
        own[:, :, 2] += self.acceleration_gain * follows[:, :, 0]
        return -np.linalg.solve(np.eye(3) - own, self.state_gain @ plant)

    def closed(self) -> NDArray[np.float64]:
        """Transition matrix of the closed loop, shape (n, n), each component in SI units."""
        inputs, own = len(self.plant_taps), len(self.command_taps)
        last = SIZE + 3 * max(inputs - 1, own - 1, self.acceleration_tap)
        command = np.zeros((3, last + 1))
        command[:, :SIZE] = self.state_gain
        for tap in range(1, own):
            command[:, _sent(tap)] = self.command_taps[tap]
        acceleration = np.zeros(last + 1)
        acceleration[last] = 1.0 - self.acceleration_share
        acceleration[_sent(self.acceleration_tap)][2] = self.acceleration_share
        command += np.outer(self.acceleration_gain, acceleration)
        following = np.zeros((last + 1, last + 1))
        following[:SIZE] = self.plant_taps[0] @ command
        following[:SIZE, :SIZE] += self.plant_step
        for tap in range(1, inputs):
            following[:SIZE, _sent(tap)] += self.plant_taps[tap]
        following[_sent(1)] = command
        following[SIZE + 3 : last, SIZE : last - 3] = np.eye(last - SIZE - 3)
        following[last] = acceleration
        return following

    def growth(self) -> float:
        """Spectral radius of the closed loop [-]: below 1 it is stable."""
        return float(np.max(np.abs(np.linalg.eigvals(self.closed()))))


def sampled_loop(
    period: float,
    gain: NDArray[np.float64],
    dynamics: tuple[NDArray[np.float64], NDArray[np.float64]],
    plant: Response,
    predicted: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
    told: Response,
) -> SampledLoop:
    """The loop of a static gain.

    Args:
        period: T in [s].
        gain: Effect of the predicted deviation on the command, shape (3, 8).
        dynamics: A and B of the aircraft, shapes (8, 8) and (8, 3), in SI units.
        plant: How the aircraft responds.
        predicted: A and B by which the controller predicts, shapes (8, 8) and (8, 3); None where it
            does not predict.
        told: How it takes the aircraft to respond.
    """
    plant_step, plant_taps = _plant(period, dynamics, plant)
    own = np.zeros((1, 3, 3))
    state_gain, acceleration_gain = gain, np.zeros(3)
    share, tap = 1.0, 1
    if predicted is not None:
        ahead, effects = _prediction(period, predicted, told.dead_times)
        own, state_gain = gain @ effects, gain @ ahead
        acceleration_gain, state_gain = state_gain[:, ACCELERATION].copy(), state_gain.copy()
        state_gain[:, ACCELERATION] = 0.0
        lag, dead_time = told.lags[2], told.dead_times[2]
        share = followed(period, lag)
        tap = _periods_before(-0.5 * period - dead_time, period)
    return SampledLoop(
        period, plant_step, plant_taps, state_gain, own, acceleration_gain, share, tap
    )


def _plant(
    period: float, dynamics: tuple[NDArray[np.float64], NDArray[np.float64]], response: Response
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Step of the aircraft under held commands that act after dead times."""
    whole, fractions = np.divmod(response.dead_times + ROUNDING, period)
    taps = np.zeros((int(np.max(whole)) + 2, SIZE, 3))
    for axis in range(3):
        late, early = int(whole[axis]), float(fractions[axis])
        rest, new = _held(dynamics, period - early)
        _, old = _held(dynamics, early)
        taps[late, :, axis] = new[:, axis]
        taps[late + 1, :, axis] = (rest @ old)[:, axis]
    return _held(dynamics, period)[0], taps * response.gains


def _prediction(
    period: float,
    dynamics: tuple[NDArray[np.float64], NDArray[np.float64]],
    dead_times: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the navigator does: see ``Navigator._at_effect``."""
    delay = float(np.max(dead_times))
    count = max(1, math.ceil(delay / LONGEST_SUBSTEP - ROUNDING))
    substep = delay / count
    step, effect = _held(dynamics, substep)
    longest = _periods_before(0.5 * substep - delay, period)
    ahead, taps = np.eye(SIZE), np.zeros((longest + 1, SIZE, 3))
    for index in range(count):
        ahead, taps = step @ ahead, step @ taps
        for axis in range(3):
            middle = (index + 0.5) * substep - dead_times[axis]
            taps[_periods_before(middle, period), :, axis] += effect[:, axis]
    return ahead, taps


def _periods_before(time: float, period: float) -> int:
    """How many periods before now the command was sent that is demanded at a time from now."""
    return max(1, -math.floor(time / period + ROUNDING))


def _held(
    dynamics: tuple[NDArray[np.float64], NDArray[np.float64]], duration: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """State transition over a time [s] and the effect of an input that is held over it."""
    a, b = dynamics
    both = np.zeros((SIZE + 3, SIZE + 3))
    both[:SIZE, :SIZE], both[:SIZE, SIZE:] = a, b
    from scipy.linalg import expm  # takes long to import, and no command waits for margins

    both = expm(both * duration)
    return both[:SIZE, :SIZE], both[:SIZE, SIZE:]


def _sent(tap: int) -> slice:
    """Where the commands of so many periods before stand in the state of the closed loop."""
    return slice(SIZE + 3 * tap - 3, SIZE + 3 * tap)


def _sum(taps: NDArray[np.float64], z: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(sum(effect * z**-tap for tap, effect in enumerate(taps)))
