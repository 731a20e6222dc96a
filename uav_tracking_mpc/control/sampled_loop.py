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

r"""The sampled closed loop near the orbit: lag, dead time, prediction and a static gain.

Every T seconds the controller measures the deviation :math:`\delta_k`, predicts it to when the new
command takes effect, through the commands that are under way, and answers
:math:`u_k = -K \hat\delta_k`. The plant holds :math:`u_k` for T, a dead time later. A dead time
:math:`\theta = l T + f` that is no multiple of T is exact (Franklin, Powell, Workman, "Digital
control of dynamic systems", 3rd ed., section 4.3.4):

.. math::

    \delta_{k+1} = e^{AT} \delta_k + \Gamma_a u_{k-l-1} + \Gamma_b u_{k-l}, \quad
    \Gamma_a = e^{A(T-f)} \int_0^f e^{As} ds\, B, \quad
    \Gamma_b = \int_0^{T-f} e^{As} ds\, B.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.orbit_deviation import ACCELERATION, SIZE
from uav_tracking_mpc.dynamics.response import Response
from uav_tracking_mpc.estimation.navigator import LONGEST_SUBSTEP, ROUNDING

SLOWEST = 1e-2  # rad/s, the lowest frequency of a response


@dataclass(frozen=True)
class SampledLoop:
    """The loop of the module's docstring.

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
        share = -math.expm1(-period / lag) if lag else 1.0
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
    """What the navigator does: see ``Navigator._flown_through``."""
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
    total = np.zeros((len(z), *taps.shape[1:]), dtype=complex)
    for tap, effect in enumerate(taps):
        total += effect * z**-tap
    return total
