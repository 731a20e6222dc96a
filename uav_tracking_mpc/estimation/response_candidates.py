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

import math

import numpy as np
from numpy.typing import NDArray

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
        size = 2 * CAPACITY  # moved to the front when full
        self._times = np.zeros(size)
        self._inputs = np.zeros((3, size))
        self._rates = np.zeros((3, size, len(LAGS)))
        self._gained = np.zeros((size, len(LAGS)))
        shape = 3, len(DEAD_TIMES), len(LAGS)
        self._response, self._held = np.zeros(shape), np.zeros(shape)
        self.reset(0.0, np.zeros(3))

    def reset(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Begin anew, in a steady flight.

        Args:
            time: When it begins in [s].
            inputs: (u_psi, u_chi, u_v) flown since long ago, shape (3,).
        """
        self._count = 1
        self._times[0], self._inputs[:, 0], self._gained[0] = time, inputs, 0.0
        self._rates[:, 0] = inputs[:, np.newaxis]
        self._plan: tuple[float, NDArray[np.float64], float] | None = None
        self.end = time

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
        self._change(max(sent, float(self._times[self._count - 1])), self._segment(sent))

    def at(self, time: float) -> NDArray[np.float64]:
        """Responses at a time: turn rate, path-angle rate, and the airspeed that was gained.

        Args:
            time: In [s], not long before the last command.

        Returns:
            Shape (3, dead times, lags), in [rad/s], [rad/s], [m/s]; overwritten by the next call.
        """
        self._follow_plan(time)
        times = time - DEAD_TIMES
        piece = self._times[: self._count].searchsorted(times, side="right") - 1
        np.maximum(piece, 0, out=piece)
        elapsed = np.maximum(times - self._times[piece], 0.0)[:, np.newaxis]
        decay = np.exp(elapsed * -_RATES)
        response, held = self._response, self._held
        held[:] = self._inputs[:, piece, np.newaxis]
        np.take(self._rates, piece, axis=1, out=response, mode="clip")
        response -= held
        response *= decay
        # The integral of what is lacking is tau times the part that has decayed.
        start = np.take(self._rates[ACCELERATION], piece, axis=0)
        start -= held[ACCELERATION]
        start -= response[ACCELERATION]
        start /= _RATES
        start += held[ACCELERATION] * elapsed
        response += held
        np.add(np.take(self._gained, piece, axis=0), start, out=response[ACCELERATION])
        return response

    def _segment(self, time: float) -> NDArray[np.float64]:
        assert self._plan is not None
        begin, inputs, step = self._plan
        return inputs[min(max(int((time - begin) / step), 0), len(inputs) - 1)]

    def _follow_plan(self, time: float) -> None:
        """The present plan's segments up to a time, which is past the last change."""
        if self._plan is None:
            return
        begin, inputs, step = self._plan
        last = float(self._times[self._count - 1])
        first = math.floor((last - begin) / step) + 1
        for segment in range(max(first, 1), len(inputs)):
            start = begin + segment * step
            if start > time:
                return
            if start > last:
                self._change(start, inputs[segment])

    def _change(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Other inputs are flown from a time on, not before the last change."""
        now = self._count - 1
        held = self._inputs[:, now]
        if (held == inputs).all():
            return
        if self._count == len(self._times):
            for array in (self._inputs.T, self._rates.swapaxes(0, 1), self._times, self._gained):
                array[:CAPACITY] = array[CAPACITY:]
            self._count, now = CAPACITY, CAPACITY - 1
            held = self._inputs[:, now]
        elapsed = time - float(self._times[now])
        before, column = self._rates[:, now], held[:, np.newaxis]
        after = (before - column) * np.exp(-elapsed * _RATES) + column
        self._rates[:, now + 1] = after
        lost = (before[ACCELERATION] - after[ACCELERATION]) / _RATES
        self._gained[now + 1] = self._gained[now] + held[ACCELERATION] * elapsed + lost
        self._times[now + 1], self._inputs[:, now + 1] = time, inputs
        self._count += 1
