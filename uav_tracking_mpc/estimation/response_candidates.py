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
import itertools

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.symbolic.layout import Layout
from uav_tracking_mpc.symbolic.native_code import NativeFunction

LAGS = np.array([0.0, 0.05, 0.1, 0.15, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0, 1.4, 2.0])  # s
DEAD_TIMES = np.concatenate([np.arange(0.0, 0.6, 0.05), np.arange(0.6, 1.55, 0.1)])  # s
ACCELERATION = 2  # channel of u_v; its integral, the airspeed, is what is measured
_RATES = 1.0 / np.maximum(LAGS, 1e-4)  # 1/s
# Commands must be known for the longest dead time, at rates up to 200 Hz.
CAPACITY = 512


# Of each piece between two changes of the inputs: what is held in it, and at its beginning the rate
# by each lag, channel by channel, and the airspeed gained.
PIECE = Layout(held=3, rates=3 * len(LAGS), gained=len(LAGS))


class ResponseCandidates:
    """Responses to the commands that were sent, for each lag and dead time.

    Attributes:
        end: When the last command that is known ends in [s].
        responses: As of :meth:`at`, flat.
    """

    def __init__(self) -> None:
        # By the times at which the inputs changed; moved to the front when full.
        self._times, self._pieces = np.zeros(2 * CAPACITY), np.zeros((2 * CAPACITY, PIECE.size))
        self._evaluated = NativeFunction(_responses())
        (self.responses,) = self._evaluated.results
        flown, self._since, left = self._evaluated.arguments
        self._flown, self._left = flown.reshape(-1, PIECE.size), left.reshape(-1, len(LAGS))
        self.reset(0.0, np.zeros(3))

    def reset(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Begin anew, in a steady flight.

        Args:
            time: When it begins in [s].
            inputs: (u_psi, u_chi, u_v) flown since long ago, shape (3,).
        """
        self._newest, self._times[0] = 0, time
        rates = np.repeat(inputs, len(LAGS))
        PIECE.fill(self._pieces[0], held=inputs, rates=rates, gained=0.0)
        self._plan, self.end = (time, inputs[np.newaxis], 1.0), time
        self._sent = time  # segments of the plan from before are none

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
        self._sent = sent
        segment = min(max(int((sent - begin) / step), 0), len(inputs) - 1)
        self._change(max(sent, float(self._times[self._newest])), inputs[segment])

    def at(self, time: float) -> NDArray[np.float64]:
        """Responses at a time: turn rate, path-angle rate, and the airspeed that was gained.

        Args:
            time: In [s], not long before the last command.

        Returns:
            Shape (3, dead times, lags), in [rad/s], [rad/s], [m/s]; overwritten by the next call.
        """
        self._follow_plan(time)
        times = time - DEAD_TIMES
        known = self._times[: self._newest + 1]
        piece = np.maximum(known.searchsorted(times, side="right") - 1, 0)
        self._pieces.take(piece, 0, self._flown, "clip")
        np.maximum(times - self._times[piece], 0.0, out=self._since)
        np.exp(np.multiply.outer(self._since, -_RATES, out=self._left), out=self._left)
        self._evaluated.evaluate()
        return self.responses.reshape(3, len(DEAD_TIMES), len(LAGS))

    def _follow_plan(self, time: float) -> None:
        """The present plan's segments up to a time, which is past the last change."""
        (begin, inputs, step), last = self._plan, max(float(self._times[self._newest]), self._sent)
        for segment in range(1, len(inputs)):
            if last < begin + segment * step <= time:
                self._change(begin + segment * step, inputs[segment])

    def _change(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Other inputs are flown from a time on, not before the last change."""
        now = self._newest
        piece = PIECE.parts(self._pieces[now])
        if (piece.held == inputs).all():
            return
        elapsed = time - float(self._times[now])
        held, before = piece.held[:, np.newaxis], piece.rates.reshape(3, -1)
        after = (before - held) * np.exp(-elapsed * _RATES) + held
        lost = (before[ACCELERATION] - after[ACCELERATION]) / _RATES
        gained = piece.gained + held[ACCELERATION] * elapsed + lost
        if now + 1 == len(self._times):
            for values in (self._times, self._pieces):
                values[:CAPACITY] = values[CAPACITY:]
            now = CAPACITY - 1
        self._newest, self._times[now + 1] = now + 1, time
        PIECE.fill(self._pieces[now + 1], held=inputs, rates=after.reshape(-1), gained=gained)


@functools.cache
def _responses() -> ca.Function:
    """Responses at a time, from the pieces of commands that are flown at it.

    Of one piece for each dead time, flat; for how long it has lasted [s]; and which share of what
    lacks each lag leaves [-], shape (dead times, lags).
    """
    flown = ca.SX.sym("flown", PIECE.size * len(DEAD_TIMES))
    since = ca.SX.sym("since", len(DEAD_TIMES))
    left = ca.SX.sym("left", len(DEAD_TIMES) * len(LAGS))
    pieces = [PIECE.parts(piece) for piece in ca.vertsplit(flown, PIECE.size)]
    lefts, rates = ca.vertsplit(left, len(LAGS)), ca.DM(_RATES)
    rows: list[list[ca.SX]] = [[], [], []]
    for piece, lasted, remains in zip(pieces, ca.vertsplit(since), lefts, strict=True):
        for channel, begun in enumerate(ca.vertsplit(piece.rates, len(LAGS))):
            command = piece.held[channel]
            lacks = begun - command
            if channel == ACCELERATION:
                # The integral of what is lacking is tau times the part that has decayed.
                decayed = (lacks - lacks * remains) / rates
                rows[channel].append(piece.gained + (decayed + command * lasted))
            else:
                rows[channel].append(lacks * remains + command)
    return ca.Function("responses", [flown, since, left], [ca.vertcat(*itertools.chain(*rows))])
