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

"""The numbers of a flight: ``metrics.json``.

Errors are those of :attr:`uav_tracking_mpc.simulation.flight_log.FlightLog.error`. A value that
cannot be given (nothing recorded, never settled, not finite) is None: JSON knows no NaN.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.simulation.flight_log import FlightLog

# Half widths of the bands that count as settled in still air, [m], [m], [m/s], [rad].
STILL_AIR_BANDS = {"range": 1.0, "altitude": 1.0, "speed": 0.1, "bearing": 0.05}

SPACING = 0.045  # s at least between samples that a rate is taken from
LEAST_SAMPLES = 8  # for a rate

# Columns of FlightLog.error, and their units as names of numbers have them.
COLUMNS = {"range": 0, "bearing": 1, "altitude": 2, "pitch": 3, "speed": 4}
UNITS = {"range": "m", "bearing": "rad", "altitude": "m", "pitch": "rad", "speed": "mps"}


def metrics(log: FlightLog) -> dict[str, Any]:
    """Everything that ``metrics.json`` holds.

    Args:
        log: Record of the flight.

    Returns:
        Plain floats, ints, strings, None and dictionaries of these, never NaN:

        - ``config``, ``duration_s``, ``speed``
        - ``settling_s``: per quantity of :func:`settling_bands` see :func:`settling_time`
        - ``settling_bands``: these, in SI
        - ``steady_state``: errors over the last third of the flight; ``horizontal_rms_m`` is that
          of sqrt(r^2 - z^2) against the radius of the orbit, ``bank_rate_rms_dps`` see
          :func:`bank_rate_rms`
        - ``final``: signed errors of the last sample
        - ``solver``: wall time of the solves, their number and how many did not converge
        - ``latency_us``: only where the flight measured it
        - ``commands``: what the command link saw
        - ``unusable_messages``: only where there were some
        - ``link``: only with a real autopilot; ``latency_ms`` is the median
    """
    errors = dict(zip(COLUMNS, log.error.T, strict=True))
    steady = {name: values[_last_third(log)] for name, values in errors.items()}
    bands = settling_bands(log)
    numbers: dict[str, Any] = {
        "config": log.config,
        "duration_s": _plain(log.duration),
        "speed": _plain(log.speed),
        "settling_s": {
            name: settling_time(log.time, errors[name], band) for name, band in bands.items()
        },
        "settling_bands": {name: _plain(band) for name, band in bands.items()},
        "steady_state": {
            "range_rms_m": _rms(steady["range"]),
            "range_max_m": _plain(np.max(np.abs(steady["range"]), initial=-np.inf)),
            "altitude_rms_m": _rms(steady["altitude"]),
            "speed_rms_mps": _rms(steady["speed"]),
            "horizontal_rms_m": _rms(_horizontal_error(log)[_last_third(log)]),
            "bank_rate_rms_dps": bank_rate_rms(log),
        },
        "final": {
            f"{name}_error_{UNITS[name]}": _plain(values[-1] if len(values) else np.nan)
            for name, values in errors.items()
        },
        "solver": {
            "name": log.solver,
            **_microseconds(log.solve_time),
            "solves": len(log.solve_time),
            "failures": int(log.failures),
        },
        "commands": asdict(log.commands),
    }
    if log.unusable:
        numbers["unusable_messages"] = log.unusable
    if log.latency is not None:
        numbers["latency_us"] = {name: _plain(value) for name, value in asdict(log.latency).items()}
    if log.link is not None:
        link = log.link
        numbers["link"] = {
            "dialect": link.dialect,
            "rate_hz": _plain(link.rate),
            "latency_ms": _plain(link.latency),
            "latency_p99_ms": _plain(link.latency_p99),
            "lost": link.lost,
            "refused": link.refused,
        }
    return numbers


def settling_bands(log: FlightLog) -> dict[str, float]:
    r"""Half widths of the bands in which a flight counts as settled, in SI.

    They are those of still air, and what gusts move against which nobody can fly. Three standard
    deviations :math:`3\sigma` of the air's velocity over the last third of the flight (mean of the
    three axes) change the airspeed at once, the bearing by the angle of drift, and the position
    within a second:

    .. math:: 1\,\mathrm{m} + 3\sigma \cdot 1\,\mathrm{s}, \quad
        0.1\,\mathrm{m/s} + 3\sigma, \quad 0.05 + 3\sigma / v_d

    Args:
        log: Record of the flight.
    """
    wind = log.wind[_last_third(log)]
    wind = wind[np.all(np.isfinite(wind), axis=1)]
    gusts = 3.0 * math.sqrt(float(np.mean(np.var(wind, axis=0)))) if len(wind) else 0.0
    moved = {"range": gusts, "altitude": gusts, "speed": gusts, "bearing": gusts / log.orbit.speed}
    return {name: band + moved[name] for name, band in STILL_AIR_BANDS.items()}


def settling_time(
    time: NDArray[np.float64], error: NDArray[np.float64], band: float
) -> float | None:
    """First time from which on ``abs(error) < band`` at every sample.

    Args:
        time: Times of the samples in [s], shape (n,).
        error: Shape (n,); a sample that is not finite counts as outside.
        band: Half width of the band, in the unit of the error [SI].

    Returns:
        Time in [s], or None if the last sample is outside or there is none.
    """
    outside = np.flatnonzero(~(np.abs(error) < band))
    first_inside = int(outside[-1]) + 1 if len(outside) else 0
    return _plain(time[first_inside]) if first_inside < len(time) else None


def range_errors(log: FlightLog) -> NDArray[np.float64]:
    """Errors in range over the last third of the flight, shape (k,), in [m].

    Args:
        log: Record of the flight.
    """
    return log.error[_last_third(log), COLUMNS["range"]]


def bank_rate_rms(log: FlightLog) -> float | None:
    r"""RMS of the rate of the bank that was flown over the last third of the flight, in [deg/s].

    The bank is that of the measured attitude or, where there is none, that of a coordinated turn
    between two samples, as measured:

    .. math:: \tan\phi = \frac{\bar v}{g} \frac{\Delta\psi}{\Delta t}

    Args:
        log: Record of the flight.
    """
    late = _last_third(log)
    time = log.time[late]
    if len(time) < LEAST_SAMPLES or not np.all(np.diff(time) > 0.0):
        return None
    # Stamps of autopilots are whole milliseconds: samples must not be too close for a rate.
    stride = max(1, math.ceil(SPACING / float(np.median(np.diff(time)))))
    time = time[::stride]
    if log.measured_bank is not None:
        return _rms(np.degrees(np.diff(log.measured_bank[late][::stride]) / np.diff(time)))
    _, _, _, heading, _, airspeed = log.vehicle[late][::stride].T
    turn_rate = np.asarray(wrap_angle(np.diff(heading))) / np.diff(time)
    bank = np.arctan(0.5 * (airspeed[1:] + airspeed[:-1]) * turn_rate / GRAVITY)
    rate = np.diff(bank) / (0.5 * (time[2:] - time[:-2]))
    return _rms(np.degrees(rate))


def _last_third(log: FlightLog) -> NDArray[np.bool_]:
    """Which samples belong to the last third of the recorded time, shape (n,)."""
    if not len(log.time):
        return np.zeros(0, dtype=bool)
    begin, end = log.time[0], log.time[-1]
    # The last sample always belongs, whatever rounding does to a record of one instant.
    return np.asarray(log.time >= min(begin + 2.0 / 3.0 * (end - begin), end))


def _horizontal_error(log: FlightLog) -> NDArray[np.float64]:
    """Horizontal distance to the target minus the radius of the orbit, shape (n,), in [m]."""
    x, y = (log.vehicle[:, :2] - log.target[:, :2]).T
    return np.asarray(np.hypot(x, y) - log.radius)


def _rms(values: NDArray[np.float64]) -> float | None:
    return _plain(np.sqrt(np.mean(values**2))) if len(values) else None


def _microseconds(seconds: NDArray[np.float64]) -> dict[str, float | None]:
    """Median, 99th percentile and maximum of the finite durations, in [us]."""
    measured = 1e6 * seconds[np.isfinite(seconds)]
    if not len(measured):
        return {"median_us": None, "p99_us": None, "max_us": None}
    return {
        "median_us": _plain(np.median(measured)),
        "p99_us": _plain(np.percentile(measured, 99.0)),
        "max_us": _plain(np.max(measured)),
    }


def _plain(value: Any) -> float | None:
    """A Python float, or None where JSON has no number for it."""
    number = float(value)
    return number if math.isfinite(number) else None
