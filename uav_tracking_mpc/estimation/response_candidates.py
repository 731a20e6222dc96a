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

r"""What the aircraft would have flown if its lag and dead time were these, for a grid of both.

A channel with lag tau and dead time D follows the command u as
:math:`\tau \dot\omega(t) = u(t - D) - \omega(t)`: it is the channel without dead time, D later. So
one filter a lag is enough. Commands are held between the times at which they change, where the
filter's solution is closed: every dead time is met exactly, also between two samples.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.symbolic.native_code import NativeFunction

LAGS = np.array([0.0, 0.05, 0.1, 0.15, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0, 1.4, 2.0])  # s
DEAD_TIMES = np.concatenate([np.arange(0.0, 0.6, 0.05), np.arange(0.6, 1.55, 0.1)])  # s
ACCELERATION = 2  # channel of u_v; its integral, the airspeed, is what is measured
_RATES = 1.0 / np.maximum(LAGS, 1e-4)  # 1/s
# Commands must be known for the longest dead time, at rates up to 200 Hz.
CAPACITY = 512


class ResponseCandidates:
    """Responses to the commands that were sent, for each lag and dead time.

    Attributes:
        end: When the last command that is known ends in [s].
    """

    def __init__(self) -> None:
        # By the times at which the inputs changed; moved to the front when full.
        size = 2 * CAPACITY
        self._times, self._inputs = np.zeros(size), np.zeros((size, 3))
        self._rates, self._gained = np.zeros((size, 3, len(LAGS))), np.zeros((size, len(LAGS)))
        self._responses = NativeFunction(_responses())
        self.reset(0.0, np.zeros(3))

    def reset(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Begin anew, in a steady flight.

        Args:
            time: When it begins in [s].
            inputs: (u_psi, u_chi, u_v) flown since long ago, shape (3,).
        """
        self._newest = 0
        self._times[0], self._inputs[0], self._gained[0] = time, inputs, 0.0
        self._rates[0] = inputs[:, np.newaxis]
        self._plan, self.end = (time, inputs[np.newaxis], 1.0), time

    def commanded(
        self, sent: float, begin: float, inputs: NDArray[np.float64], step: float
    ) -> None:
        """Record a plan: see :meth:`CommandHistory.add`.

        Args:
            sent: From when on it is flown in [s].
            begin: When its first segment begins in [s], at or before ``sent``.
            inputs: (u_psi, u_chi, u_v) at begin, begin + step, ..., shape (n, 3), held in between.
            step: Length of a segment in [s].
        """
        self._follow_plan(sent)
        self._plan, self.end = (begin, inputs, step), begin + step * len(inputs)
        segment = min(max(int((sent - begin) / step), 0), len(inputs) - 1)
        self._change(max(sent, float(self._times[self._newest])), inputs[segment])

    def at(self, time: float) -> NDArray[np.float64]:
        """Responses at a time: turn rate, path-angle rate, and the airspeed that was gained.

        Args:
            time: In [s], not long before the last command.

        Returns:
            Shape (3, dead times, lags), in [rad/s], [rad/s], [m/s].
        """
        self._follow_plan(time)
        times = time - DEAD_TIMES
        known = self._times[: self._newest + 1]
        piece = np.maximum(known.searchsorted(times, side="right") - 1, 0)
        begun, held, since, left, gained = self._responses.arguments
        since[:] = np.maximum(times - self._times[piece], 0.0)
        begun[:], held[:] = self._rates[piece].reshape(-1), self._inputs[piece].reshape(-1)
        gained[:] = self._gained[piece].reshape(-1)
        left[:] = np.exp(since[:, np.newaxis] * -_RATES).reshape(-1)
        self._responses.evaluate()
        return self._responses.results[0].reshape(3, len(DEAD_TIMES), len(LAGS)).copy()

    def _follow_plan(self, time: float) -> None:
        """The present plan's segments up to a time, which is past the last change."""
        (begin, inputs, step), last = self._plan, float(self._times[self._newest])
        for segment in range(1, len(inputs)):
            if last < begin + segment * step <= time:
                self._change(begin + segment * step, inputs[segment])

    def _change(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Other inputs are flown from a time on, not before the last change."""
        now = self._newest
        held, before = self._inputs[now, :, np.newaxis], self._rates[now]
        if (held[:, 0] == inputs).all():
            return
        elapsed = time - float(self._times[now])
        after = (before - held) * np.exp(-elapsed * _RATES) + held
        lost = (before[ACCELERATION] - after[ACCELERATION]) / _RATES
        gained = self._gained[now] + held[ACCELERATION] * elapsed + lost
        changes = (
            (self._times, time),
            (self._inputs, inputs),
            (self._rates, after),
            (self._gained, gained),
        )
        full = now + 1 == len(self._times)
        self._newest = CAPACITY if full else now + 1
        for values, newest in changes:
            if full:
                values[:CAPACITY] = values[CAPACITY:]
            values[self._newest] = newest


@functools.cache
def _responses() -> ca.Function:
    """Responses at a time, from the beginnings of the pieces of commands that are flown at it.

    Of the rates at these beginnings, shape (dead times, 3, lags), and the commands held since,
    shape (dead times, 3), both in [rad/s, rad/s, m/s^2]; for how long that is [s]; which share of
    what lacks each lag leaves [-], shape (dead times, lags); and the airspeed gained until then, of
    the same shape, in [m/s].
    """
    which, lag = (index.reshape(-1) for index in np.indices((len(DEAD_TIMES), len(LAGS))))
    begun, held = ca.SX.sym("begun", 3 * which.size), ca.SX.sym("held", 3 * len(DEAD_TIMES))
    since, left = ca.SX.sym("since", len(DEAD_TIMES)), ca.SX.sym("left", which.size)
    gained = ca.SX.sym("gained", which.size)
    commands = [held[(3 * which + channel).tolist()] for channel in range(3)]
    lacking = [
        begun[((3 * which + channel) * len(LAGS) + lag).tolist()] - command
        for channel, command in enumerate(commands)
    ]
    rows = [each * left + command for each, command in zip(lacking, commands, strict=True)]
    # The integral of what is lacking is tau times the part that has decayed.
    lacks, command = lacking[ACCELERATION], commands[ACCELERATION]
    decayed = (lacks - lacks * left) / ca.DM(_RATES[lag])
    rows[ACCELERATION] = gained + (decayed + command * since[which.tolist()])
    return ca.Function("responses", [begun, held, since, left, gained], [ca.vertcat(*rows)])
