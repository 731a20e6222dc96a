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

r"""Lag, dead time and gain of each channel, from commands as they were sent and what was measured.

For each lag and dead time of a grid (:class:`ResponseCandidates`) the least-squares gain g between
the candidate's response x and the measured one y is known at any time from three sums, which
forget exponentially:

.. math::

    J(\tau, D) = \min_g \sum_k e^{-(t - t_k)/T_m} (y_k - g\, x_k(\tau, D))^2 .

Both pass the same high pass before, which takes biases of the sensors and slow disturbances out.
J is refined between the points of the grid by parabolas, first over D for each tau, then along the
valley so found over tau; with the variance of the residual the parabolas' curvatures give the
standard deviations (e.g. Ljung, System Identification, 1999, chapter 9). Residuals that follow each
other are worth less than as many independent ones: the variance is that of an AR(1) process at low
frequencies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.noise_meter import LONGEST_GAP
from uav_tracking_mpc.estimation.state_gate import SPEED_LIMIT

CHANNELS = ("turn rate", "path-angle rate", "acceleration")
LAGS = np.array([0.0, 0.05, 0.1, 0.15, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0, 1.4, 2.0])  # s
DEAD_TIMES = np.concatenate([np.arange(0.0, 0.6, 0.05), np.arange(0.6, 1.55, 0.1)])  # s
ACCELERATION = 2  # channel of u_v; its integral, the airspeed, is what is measured
_DECAY = -1.0 / np.maximum(LAGS, 1e-4)  # 1/s
# By channel and lag, how far a step of the inputs is from being followed at its beginning: all of
# it, and of the airspeed what is gained until it is.
_LACKING = np.array([np.ones(len(LAGS)), np.ones(len(LAGS)), 1.0 / _DECAY])  # -, -, s

# The sum of lag and dead time, or the lag alone, is trusted below the first deviation and until the
# second: what it is off by adds to the phase. The gain likewise.
DELAY_TRUST = (0.05, 0.1)  # s
# -; beyond the second one there may be no response at all, only noise that looks alike
GAIN_TRUST = (0.03, 0.1)
LOOSER = 3.0  # -, times both: what a channel that swings is flown by is known to be wrong
MEMORY = 60.0  # s, T_m
WASHOUT = 10.0  # s, time constant of the high pass: shorter than an orbit, longer than any lag
GAIN_LIMITS = 0.5, 1.6  # -, of a gain that is believed
# rad/s, rad/s, m/s: what is measured is never believed to be better than this, sample by sample;
# a response that is lost in it is none.
NOISE_FLOOR = 0.003, 0.003, 0.05
CORRELATION_LIMIT = 0.98  # -, of successive residuals
QUICKEST = 10.0  # rad/s, beyond which a sensor is broken
SHORTEST_PERIOD = 0.015  # s between measurements that are used: faster ones tell no more
# -, -, s: near its bank limit an aircraft turns no faster, whatever is commanded, for as long as it
# takes to lag away afterwards: share of the limit that is measured, share that is asked for, time.
SATURATION, TOO_MUCH, RECOVERY = 0.9, 1.02, 1.0
ROUNDING = 0.01  # s or -, what the parabolas are off by between the points of the grid
BEGIN = 1.5  # s after the first command, in which what was flown before it still counts
REFINED_EVERY = 8  # measurements that are taken in together, and then one channel is refined


class ChannelResponse(NamedTuple):
    """A first-order lag behind a dead time, with standard deviations.

    The sum of lag and dead time shows far better than each of them: what one is too long, the other
    is too short.

    Attributes:
        lag: Time constant in [s].
        dead_time: In [s].
        gain: Rate that is flown per rate that is commanded [-].
        lag_deviation: Standard deviation of the lag in [s].
        dead_time_deviation: Of the dead time in [s].
        delay_deviation: Of their sum in [s].
        gain_deviation: Of the gain [-].
        trusted: Whether the sum is known well enough to fly by.
        lag_trusted: Whether the lag alone is.
        gain_trusted: Whether the gain is.
    """

    lag: float = 0.0
    dead_time: float = 0.0
    gain: float = 1.0
    lag_deviation: float = math.inf
    dead_time_deviation: float = math.inf
    delay_deviation: float = math.inf
    gain_deviation: float = math.inf
    trusted: bool = False
    lag_trusted: bool = False
    gain_trusted: bool = False

    @property
    def delay(self) -> float:
        """Lag plus dead time in [s]."""
        return self.lag + self.dead_time

    def judged(self, before: ChannelResponse, swings: bool) -> ChannelResponse:
        """This estimate with what may be trusted of it, with hysteresis.

        Args:
            before: The estimate before this one.
            swings: Whether the channel has swung lately.
        """
        looser = LOOSER if swings else 1.0
        seen = self.gain_deviation < looser * GAIN_TRUST[True]
        return self._replace(
            trusted=seen and self.delay_deviation < looser * DELAY_TRUST[before.trusted],
            lag_trusted=seen and self.lag_deviation < DELAY_TRUST[before.lag_trusted],
            gain_trusted=self.gain_deviation < GAIN_TRUST[before.gain_trusted],
        )


class ResponseCandidates:
    r"""What the aircraft would have flown to the commands sent, for each lag and dead time.

    A channel with lag tau and dead time D follows the command u as
    :math:`\tau \dot\omega(t) = u(t - D) - \omega(t)`: it is the channel without dead time, D later.
    So one filter a lag is enough. Commands are held between the times at which they change, where
    the filter's solution is closed: every dead time is met exactly, also between two samples. From
    the beginning of such a piece on it is :math:`a + b t + c e^{-t / \tau}`, where b is 0 but for
    the airspeed, the integral of the last channel.

    Args:
        time: When it begins, in a steady flight, in [s].
        inputs: (u_psi, u_chi, u_v) flown since long ago, in [rad/s, rad/s, m/s^2].

    Attributes:
        end: When the last command that is known ends in [s].
    """

    def __init__(self, time: float = 0.0, inputs: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        held, flown = np.array(inputs), np.zeros((3, len(LAGS)))
        flown[:ACCELERATION] = held[:ACCELERATION, np.newaxis]
        # Of each piece: when it begins, the inputs, a and c by channel and lag
        self._pieces = [(time, held, flown, np.zeros_like(flown))]
        # When each was sent and begins, its inputs and its step: the one that is flown, of which
        # segments from before are none, and those that have come since.
        self._plans, self.end = [(time, time, held[np.newaxis], 1.0)], time

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
        self._plans.append((sent, begin, inputs, step))
        self.end = begin + step * len(inputs)

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Responses at times: turn rate, path-angle rate, and the airspeed that was gained.

        What only earlier times ask for is forgotten.

        Args:
            times: Ascending, none before those asked for last, shape (n,), in [s].

        Returns:
            Shape (n, 3, dead times, lags), in [rad/s], [rad/s], [m/s].
        """
        self._follow_plans(float(times[-1]))
        begins, held, steady, lacking = map(np.array, zip(*self._pieces, strict=True))
        delayed = times[:, np.newaxis] - DEAD_TIMES
        which = np.maximum(begins.searchsorted(delayed, side="right") - 1, 0)
        since = np.maximum(delayed - begins[which], 0.0)[..., np.newaxis]
        left = np.exp(since * _DECAY)[:, :, np.newaxis]
        responses = steady[which] + left * lacking[which]
        responses[:, :, ACCELERATION] += held[which, ACCELERATION, np.newaxis] * since
        del self._pieces[: which[-1, -1]]
        return responses.swapaxes(1, 2)

    def _follow_plans(self, time: float) -> None:
        """What has been flown up to a time, which is past the last change."""
        ends = [*(sent for sent, *_ in self._plans[1:]), time]
        for number, (sent, begin, inputs, step) in enumerate(self._plans):
            last, end = max(self._pieces[-1][0], sent), ends[number]
            if number > 0:  # it is not the one that is flown
                self._change(last, inputs[min(max(int((sent - begin) / step), 0), len(inputs) - 1)])
            for segment in range(1, min(int((end - begin) / step) + 2, len(inputs))):
                if last < (change := begin + segment * step) <= end:
                    self._change(change, inputs[segment])
        del self._plans[:-1]

    def _change(self, time: float, inputs: NDArray[np.float64]) -> None:
        """Other inputs are flown from a time on, not before the last change."""
        begin, held, steady, lacking = self._pieces[-1]
        since, step = time - begin, (held - inputs)[:, np.newaxis] * _LACKING
        steady = steady - step
        steady[ACCELERATION] += held[ACCELERATION] * since
        self._pieces.append((time, inputs, steady, np.exp(since * _DECAY) * lacking + step))


class ResponseEstimator:
    """Commands and measurements in, :class:`ChannelResponse` of three channels out.

    Args:
        commanded: How many of the channels, from the first on, are commanded; of the others, which
            the autopilot flies as it finds right, nothing is learnt.

    Attributes:
        channels: Estimates of turn rate, path-angle rate and acceleration.
        swing: Whether each of them has swung lately, shape (3,).
    """

    def __init__(self, commanded: int = 3) -> None:
        self._followed = np.arange(3) < commanded
        self._candidates = ResponseCandidates()
        # Time, time since the one before, what was measured, and whether it is of use
        self._samples: list[tuple[float, float, tuple[float, ...], tuple[bool, ...]]] = []
        # Of each candidate, and of what was measured as of one more: the response, what the high
        # pass lets through of it, sums of x x and x y; and of x with that of the next dead time.
        count = len(DEAD_TIMES) * len(LAGS)
        self._before, self._passed, self._power, self._product = np.zeros((4, 3, count + 1))
        self._following = np.zeros((3, count - len(LAGS)))
        # Of each channel: sums of 1, products of successive residuals, and their squares.
        self._sums, self._residual = np.zeros((3, 3)), np.zeros(3)
        self._nearest, self._gains = np.zeros(3, dtype=int), np.ones(3)  # the best candidate
        self.channels, self.swing = [ChannelResponse()] * 3, np.zeros(3, dtype=bool)
        self._turn = 0
        self.interrupt()

    def interrupt(self) -> None:
        """Forget commands and times, keep what has been learnt."""
        if self._samples:
            self._take_in()
        self._time: float | None = None
        self._commanded = False
        self._used = np.zeros(3, dtype=bool)
        self._saturated, self._begun, self._turn_rate_max = -math.inf, 0.0, math.inf

    def commanded(
        self, sent: float, begin: float, inputs: NDArray[np.float64], step: float
    ) -> None:
        """See :meth:`ResponseCandidates.commanded`."""
        if self._time is not None:
            self._candidates.commanded(sent, begin, inputs, step)
            self._commanded = True
            turn, (u_psi, _, _) = self.channels[0], inputs[0].tolist()
            gain = turn.gain if turn.gain_trusted else 1.0
            if abs(u_psi) * gain > TOO_MUCH * self._turn_rate_max:
                self._saturated = max(self._saturated, sent + turn.delay)

    def see(
        self,
        time: float,
        turn_rate: float,
        path_angle_rate: float,
        airspeed: float | None,
        turn_rate_max: float,
    ) -> None:
        """Take in a measurement.

        Args:
            time: Stamp of the measurement in [s].
            turn_rate: psi' in [rad/s].
            path_angle_rate: chi' in [rad/s].
            airspeed: v in [m/s]; None where none is measured.
            turn_rate_max: What the bank limit allows in [rad/s].
        """
        elapsed = math.inf if self._time is None else time - self._time
        if 0.0 <= elapsed < SHORTEST_PERIOD:
            return
        if (
            max(abs(turn_rate), abs(path_angle_rate)) > QUICKEST
            or abs(airspeed or 0.0) > SPEED_LIMIT
        ):
            self.interrupt()
            return
        if not 0.0 <= elapsed <= LONGEST_GAP or time > self._candidates.end:
            self.interrupt()
        self._time, self._turn_rate_max = time, turn_rate_max
        if not self._commanded:  # nobody knows what is flown: as if it had been for long
            self._candidates = ResponseCandidates(time, (turn_rate, path_angle_rate, 0.0))
            self._candidates.end, self._begun = math.inf, time
            return
        if abs(turn_rate) >= SATURATION * turn_rate_max:
            self._saturated = time
        measured, begun = (turn_rate, path_angle_rate, airspeed or 0.0), time - self._begun > BEGIN
        usable = begun and time - self._saturated > RECOVERY, begun, begun and airspeed is not None
        self._samples.append((time, elapsed, measured, usable))
        self._turn = (self._turn + 1) % (3 * REFINED_EVERY)
        if self._turn % REFINED_EVERY == 0:
            self._take_in()
            axis = self._turn // REFINED_EVERY
            self.channels[axis] = self._refined(axis).judged(
                self.channels[axis], bool(self.swing[axis])
            )

    def _take_in(self) -> None:
        """High pass and sums; where a sample or the one before is of no use, the step is none."""
        times, elapsed, measured, usable = map(np.array, zip(*self._samples, strict=True))
        self._samples.clear()
        weights = self._followed & usable & np.vstack([self._used, usable[:-1]])
        responses = np.concatenate(
            [self._candidates.at(times).reshape(len(times), 3, -1), measured[:, :, np.newaxis]],
            axis=2,
        )
        passed = np.diff(responses, axis=0, prepend=self._before[np.newaxis])
        passed *= weights[:, :, np.newaxis]
        befores, kept = [self._passed, *passed[:-1]], np.exp(elapsed / -WASHOUT)
        for before, after, share in zip(befores, passed, kept, strict=True):
            after += before
            after *= share
        self._before, self._passed, self._used = responses[-1], passed[-1], usable[-1]

        until = np.cumsum(elapsed)[:, np.newaxis]
        remembered, forgotten = np.exp((until - until[-1]) / MEMORY), np.exp(until[-1] / -MEMORY)
        weighed = (weights * remembered)[:, :, np.newaxis] * passed
        next_dead_time = weighed[:, :, : -1 - len(LAGS)] * passed[:, :, len(LAGS) : -1]
        self._power = forgotten * self._power + (weighed * passed).sum(0)
        self._product = forgotten * self._product + (weighed * passed[:, :, -1:]).sum(0)
        self._following = forgotten * self._following + next_dead_time.sum(0)
        residual = weights * (passed[:, :, -1] - self._gains * passed[:, range(3), self._nearest])
        successive = residual * np.vstack([self._residual, residual[:-1]])
        self._sums, self._residual = (
            forgotten * self._sums + (remembered * (weights, successive, residual**2)).sum(1),
            residual[-1],
        )

    def _refined(self, axis: int) -> ChannelResponse:
        """Minimum of J and its curvature."""
        power, product, following = (
            sums[axis, : len(DEAD_TIMES) * len(LAGS)].reshape(-1, len(LAGS))
            for sums in (self._power, self._product, self._following)
        )
        weight, successive, squared = self._sums[:, axis].tolist()
        if not power.any():
            return ChannelResponse()
        dead_times, gains, explained, bends = _between(power, product, following)
        valley = self._power[axis, -1] - explained
        # Along the valley, over the lag.
        best = min(max(int(np.argmin(valley)), 1), len(LAGS) - 2)
        three = slice(best - 1, best + 2)
        lags = LAGS[three]
        lag, least, bend = _minimum(lags, valley[three])
        delay, delay_slope, _ = _parabola(lags, lags + dead_times[three], lag)
        gain, gain_slope, _ = _parabola(lags, gains[three], lag)
        gain = min(max(gain, GAIN_LIMITS[0]), GAIN_LIMITS[1])
        nearest = int(np.argmin(np.abs(DEAD_TIMES - dead_times[best])))
        self._nearest[axis], self._gains[axis] = nearest * len(LAGS) + best, gain

        correlation = successive / squared if squared > 0.0 else 0.0
        correlation = min(max(correlation, 0.0), CORRELATION_LIMIT)
        # as if a residual was independent of the one before
        alone = (1.0 + correlation) / (1.0 - correlation)
        variance = max(least, 0.0) / max(weight - 4.0, 1.0) * alone + NOISE_FLOOR[axis] ** 2
        along = math.sqrt(2.0 * variance / max(bend, 1e-300))
        lag_deviation = math.hypot(along, ROUNDING)
        of_dead_time = math.sqrt(2.0 * variance / max(float(bends[best]), 1e-300))
        of_gain = math.sqrt(variance / max(float(power[nearest, best]), 1e-300))
        return ChannelResponse(
            lag=lag,
            dead_time=max(delay - lag, 0.0),
            gain=gain,
            lag_deviation=lag_deviation,
            dead_time_deviation=math.hypot(lag_deviation, of_dead_time),
            delay_deviation=math.hypot(delay_slope * along, of_dead_time, ROUNDING),
            gain_deviation=math.hypot(gain_slope * along, of_gain, ROUNDING),
        )


def _between(
    power: NDArray[np.float64], product: NDArray[np.float64], following: NDArray[np.float64]
) -> tuple[NDArray[np.float64], ...]:
    """Best dead times between those of the grid, for each lag.

    Between two dead times a response is taken as linear: least squares with both of them.

    Args:
        power: Sums of x x, shape (dead times, lags).
        product: Of x y, shape (dead times, lags).
        following: Of x with that of the next dead time, shape (dead times - 1, lags).

    Returns:
        For each lag the best dead time, the gain there, what of y y it explains, and J'' over D.
    """
    p, q, a = power[:-1], power[1:], following
    y, z = product[:-1], product[1:]
    apart = np.maximum(p + q - 2.0 * a, 1e-12 * (p + q) + 1e-300)  # (x_i+1 - x_i)^2
    determinant = np.maximum(p * q - a * a, 1e-300)
    first, second = (q * y - a * z) / determinant, (p * z - a * y) / determinant
    share = np.clip(second / np.where(first + second > 0.0, first + second, math.inf), 0.0, 1.0)
    mixed = y + share * (z - y)
    mixed_power = (1.0 - share) ** 2 * p + 2.0 * share * (1.0 - share) * a + share**2 * q
    gain = np.clip(mixed / np.maximum(mixed_power, 1e-300), *GAIN_LIMITS)
    explained = gain * (2.0 * mixed - gain * mixed_power)
    best = explained.argmax(axis=0), np.arange(power.shape[1])
    apart_in_time = np.diff(DEAD_TIMES)[best[0]]
    return (
        DEAD_TIMES[best[0]] + share[best] * apart_in_time,
        gain[best],
        explained[best],
        2.0 * gain[best] ** 2 * apart[best] / apart_in_time**2,
    )


def _minimum(
    points: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Of the parabola through three points, inside of them: where, how much, second derivative."""
    left, middle, right = points.tolist()
    there, slope, bend = _parabola(points, values, middle)
    where = min(max(middle - slope / bend, left), right) if bend > 0.0 else middle
    there += (where - middle) * (slope + 0.5 * (where - middle) * bend)
    # At the edge of the grid the cost may bend the other way.
    least = 2.0 * abs(float(values[2] - values[0])) / (right - left) ** 2
    return where, there, max(bend, least)


def _parabola(
    points: NDArray[np.float64], values: NDArray[np.float64], where: float
) -> tuple[float, float, float]:
    """Value, slope and second derivative at a place of the parabola through three points."""
    (left, middle, right), (first, second, third) = points.tolist(), values.tolist()
    slope = (second - first) / (middle - left)
    bend = ((third - second) / (right - middle) - slope) / (right - left)
    return (
        first + (where - left) * (slope + (where - middle) * bend),
        slope + (2.0 * where - left - middle) * bend,
        2.0 * bend,
    )
