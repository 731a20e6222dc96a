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

"""The numbers of a flight, ``metrics.json``, and what they say in sentences.

Errors are those of :attr:`uav_tracking_mpc.simulation.flight_log.FlightLog.error`. A value that
cannot be given (nothing recorded, never settled, not finite) is None: JSON knows no NaN.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, wrap_angle
from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL
from uav_tracking_mpc.estimation.sensor_health import USED, SensorHealth
from uav_tracking_mpc.simulation.flight_log import FlightLog, FlownMode

# m, m, m/s, rad: half widths of the bands that count as settled in still air.
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
        - ``sensors``: see :func:`sensor_figures`
        - ``not_by_law``: only where the guidance law answered no command: that, and why, in words
        - ``unusable_messages``: only where there were some
        - ``link``: only with a real autopilot; ``latency_ms`` is the median
    """
    errors = dict(zip(COLUMNS, log.error.T, strict=True))
    steady = {name: values[_last_third(log)] for name, values in errors.items()}
    bands = settling_bands(log)
    horizontal = np.hypot(*(log.vehicle[:, :2] - log.target[:, :2]).T) - log.radius
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
            "horizontal_rms_m": _rms(horizontal[_last_third(log)]),
            "bank_rate_rms_dps": bank_rate_rms(log),
        },
        "final": {
            f"{name}_error_{UNITS[name]}": _plain(values[-1] if len(values) else np.nan)
            for name, values in errors.items()
        },
        "solver": {
            "name": log.solver,
            **microseconds(log.solve_time),
            "solves": len(log.solve_time),
            "failures": int(log.failures),
        },
        "commands": asdict(log.commands),
        "sensors": sensor_figures(log),
    }
    if log.not_by_law:
        numbers["not_by_law"] = log.not_by_law
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


def sensor_figures(log: FlightLog) -> dict[str, Any]:
    """Of each sensor of the aircraft: share of the flight in which it was used and refused, faults.

    Args:
        log: Record of the flight.

    Returns:
        By the sensor's name ``used`` and ``refused``, shares of the flight, and ``faults``: of each
        time in which it was left out ``state``, why, in a word, ``begin_s`` and ``duration_s``.
    """
    end = float(log.time[-1]) if len(log.time) else 0.0
    figures = {}
    for name in SensorHealth().states:
        news = [each for each in log.sensors if each.sensor == name]
        ends = [*(later.time for later in news[1:]), end]
        faults: list[dict[str, Any]] = [
            {"state": each.state, "begin_s": each.time, "duration_s": max(until - each.time, 0.0)}
            for each, until in zip(news, ends, strict=False)  # without news: one end too many
            if each.state != USED
        ]
        refused = sum(fault["duration_s"] for fault in faults) / end if end > 0.0 else 0.0
        figures[name] = {"used": 1.0 - refused, "refused": refused, "faults": faults}
    return figures


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
    late = np.flatnonzero(_last_third(log))
    # Stamps of an autopilot may step back for a moment, when its clock is found anew.
    late = late[np.diff(np.maximum.accumulate(log.time[late]), prepend=-np.inf) > 0.0]
    steps = np.diff(log.time[late])
    if len(late) < LEAST_SAMPLES:
        return None
    # Stamps of autopilots are whole milliseconds: samples must not be too close for a rate.
    late = late[:: max(1, math.ceil(SPACING / float(np.median(steps))))]
    time = log.time[late]
    if log.measured_bank is not None:
        return _rms(np.degrees(np.diff(log.measured_bank[late]) / np.diff(time)))
    return _rms(np.degrees(np.diff(flown_bank(log, late)) / (0.5 * (time[2:] - time[:-2]))))


def flown_bank(log: FlightLog, samples: Any = slice(None)) -> NDArray[np.float64]:
    """Bank between each two samples, shape (n - 1,), in [rad]: by the attitude where it is known.

    Else that of a coordinated turn. Right wing down positive, as everywhere.

    Args:
        log: Record of the flight.
        samples: Which samples count, as an index of arrays; all by default.
    """
    if log.measured_bank is not None:
        bank = log.measured_bank[samples]
        return np.asarray(0.5 * (bank[1:] + bank[:-1]))
    _, _, _, heading, _, airspeed = log.vehicle[samples].T
    turn_rate = np.asarray(wrap_angle(np.diff(heading))) / np.diff(log.time[samples])
    return np.asarray(bank_from_turn_rate(turn_rate, 0.5 * (airspeed[1:] + airspeed[:-1])))


def _last_third(log: FlightLog) -> NDArray[np.bool_]:
    """Which samples belong to the last third of the recorded time, shape (n,)."""
    if not len(log.time):
        return np.zeros(0, dtype=bool)
    begin, end = log.time[0], log.time[-1]
    # The last sample always belongs, whatever rounding does to a record of one instant.
    return np.asarray(log.time >= min(begin + 2.0 / 3.0 * (end - begin), end))


def _rms(values: NDArray[np.float64]) -> float | None:
    return _plain(np.sqrt(np.mean(values**2))) if len(values) else None


def microseconds(seconds: NDArray[np.float64]) -> dict[str, float | None]:
    """Median, 99th percentile and maximum of the finite durations, in [us]; None without any.

    Args:
        seconds: Shape (n,), in [s].
    """
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


BAND_UNITS = {"range": "m", "altitude": "m", "speed": "m/s", "bearing": "rad"}
LEAST_SHARE = 0.001  # -, of the whole: less is not told as a number
FALLBACKS = 12  # most that a page lists
LATE_SHARE = 0.01  # -, of the commands: with more of them a flight is not what was asked for
NOTABLE_OFFSET = 0.01  # m, mean range error that the report speaks of


def quantity(value: float | None, unit: str, digits: int = 4) -> str:
    """A number with its unit, for people.

    Args:
        value: In ``unit`` [SI]; None and what is not finite become a dash; what is smaller than
            people can use is said to be so.
        unit: Appended after a no-break space.
        digits: Significant digits, at most this many decimals.
    """
    if value is None or not np.isfinite(value):
        return "\u2013"
    least = 10.0**-digits
    if 0.0 < abs(value) < least:
        return f"< {least:.{digits}f}\u00a0{unit}"
    decimals = digits if value == 0.0 else digits - 1 - int(np.floor(np.log10(abs(value))))
    text = f"{value:.{min(max(decimals, 0), digits)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return f"{text}\u00a0{unit}".replace("-", "\u2212", 1)


def in_short(numbers: dict[str, Any], output: Path) -> list[str]:
    """A flight in lines: when it settled, how well it held, what failed, where the report is.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
        output: Folder of the report.
    """
    times = ", ".join(
        f"{name} {'never' if time is None else f'{time:.1f} s'}"
        for name, time in numbers["settling_s"].items()
    )
    steady = numbers["steady_state"]
    rms = ", ".join(
        f"{name} rms {'-' if value is None else f'{value:.4f} m'}"
        for name, value in (
            ("range", steady["range_rms_m"]),
            ("altitude", steady["altitude_rms_m"]),
        )
    )
    held = [f"settled: {times}", f"last third: {rms}"]
    if words := numbers.get("not_by_law"):
        held = [words]  # what flew was not what is asked about
    return [*held, *_failures(numbers), f"report: {output / 'report.html'}"]


def settled(numbers: dict[str, Any]) -> bool:
    """Whether range, altitude, speed and bearing all came to stay inside their bands.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    return all(time is not None for time in numbers["settling_s"].values())


def unsettled(numbers: dict[str, Any]) -> str:
    """What never came to stay inside its band, in words; empty if all did.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    return " and ".join(
        f"{name} never came to stay within {_band(numbers, name)}"
        for name, time in numbers["settling_s"].items()
        if time is None
    )


def sound(numbers: dict[str, Any]) -> bool:
    """Whether a flight settled, by what was asked for, and all but 1 % of its commands in time.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    commands = numbers["commands"]
    if "not_by_law" in numbers:
        return False
    return settled(numbers) and commands["late"] <= LATE_SHARE * commands["sent"]


def _band(numbers: dict[str, Any], name: str) -> str:
    return quantity(numbers["settling_bands"][name], BAND_UNITS[name], 2)


def verdict(numbers: dict[str, Any]) -> str:
    """One sentence: settled or not, and how well; a second one where something failed.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    times, steady, final = numbers["settling_s"], numbers["steady_state"], numbers["final"]
    if final["range_error_m"] is None:
        return "No usable record: the last sample of the flight is missing or not finite."
    if words := numbers.get("not_by_law"):
        text = f"{words[0].upper()}{words[1:]}."
    elif settled(numbers):
        text = (
            f"Settled: altitude within {_band(numbers, 'altitude')} from "
            f"{quantity(times['altitude'], 's')} on, "
            f"range from {quantity(times['range'], 's')} on; over the last third of the flight "
            f"the range held to {quantity(steady['range_rms_m'], 'm')} RMS and the altitude to "
            f"{quantity(steady['altitude_rms_m'], 'm')} RMS."
        )
    else:
        text = (
            f"Not settled: {unsettled(numbers)} of the reference; over the last third of the "
            f"flight the range error was {quantity(steady['range_rms_m'], 'm')} RMS, and at the "
            f"end the UAV was {quantity(abs(final['range_error_m']), 'm')} too "
            f"{'far out' if final['range_error_m'] > 0.0 else 'close'}."
        )
    return " ".join([text.replace("< ", "less than "), *_failures(numbers)])


def _failures(numbers: dict[str, Any]) -> list[str]:
    sentences = []
    solver, commands = numbers["solver"], numbers["commands"]
    if solver["failures"]:
        sentences.append(f"{solver['failures']} of {solver['solves']} solves did not converge.")
    if commands["late"]:
        share = commands["late"] / max(commands["sent"], 1)
        sentences.append(
            f"{commands['late']} of {commands['sent']} commands ({_percent(share)}) came late."
        )
    if commands["failsafe"]:
        times = "once" if commands["failsafe"] == 1 else f"{commands['failsafe']} times"
        sentences.append(f"There was no plan {times}: the loiter law or level wings were flown.")
    for name, sensor in numbers["sensors"].items():
        if sensor["faults"]:
            first, lost = sensor["faults"][0], sensor["refused"]
            sentences.append(
                f"The {name} was left out for {_percent(lost)} of the flight, "
                f"first as {first['state']} after {quantity(first['begin_s'], 's')}."
            )
    if unusable := numbers.get("unusable_messages"):
        sentences.append(f"{unusable} messages could not be used and are left out.")
    return sentences


def _percent(share: float) -> str:
    """What there is, however little, is more than nothing."""
    return f"{share:.1%}" if share >= LEAST_SHARE else f"less than {LEAST_SHARE:.1%}"


def fallbacks(log: FlightLog) -> list[tuple[float, float, FlownMode]]:
    """The longest times in which something else was flown than was asked for: begin, end and what.

    Args:
        log: Record of the flight.
    """
    found = [span for span in log.mode_spans if not span[2].mode.nominal]
    longest = sorted(found, key=lambda span: span[0] - span[1])[:FALLBACKS]
    return sorted(longest, key=lambda span: span[0])


# Section 3.1's steady turns for a clockwise orbit, in symbols.
FORMULAS = {"exact": "v_d / d_d", "paper": "v_d / r_d", "paper9": "v_d r_d / d_d²"}


def range_offset_finding(log: FlightLog) -> dict[str, Any] | None:
    """The range offset, where there is something to say about it.

    (9) and (11) replace d/r by cos(chi) and z/r by sin(chi), d = sqrt(r^2 - z^2). On the level
    orbit this shifts the turn rate that the controller takes for steady; the feedback makes up for
    the difference, and needs a standing error to do so.

    Args:
        log: Record of the flight.

    Returns:
        ``mean`` of the range error over the last third of the flight and ``spread``, half of its
        peak-to-peak value there, in [m]; ``from_model``, whether the controller predicted with a
        steady turn that is not the vehicle's; u_psi that holds the orbit in the prediction model,
        ``model_turn_rate``, and on the vehicle, ``exact_turn_rate``, in [rad/s], and both in
        symbols, ``model_formula`` and ``exact_formula``, empty where there is none to print. None
        if the model's turn is the plant's and the mean error is at most :data:`NOTABLE_OFFSET`, or
        if nothing was recorded.
    """
    errors = range_errors(log)
    from_model = (
        log.plant == "vehicle" and log.model != "exact" and log.model in RELATIVE_MODEL.names
    )
    if not (len(errors) and np.all(np.isfinite(errors))):
        return None
    mean = float(np.mean(errors))
    if not (from_model or abs(mean) > NOTABLE_OFFSET):
        return None
    exact = float(steady_inputs("exact", log.orbit)[0])
    sign = "\u2212" if exact < 0.0 else ""
    formula = FORMULAS.get(log.model, "")
    return {
        "mean": mean,
        "spread": 0.5 * float(np.ptp(errors)),
        "from_model": from_model,
        "model_turn_rate": float(steady_inputs(log.model, log.orbit)[0]) if from_model else exact,
        "exact_turn_rate": exact,
        "model_formula": sign + formula if formula else "",
        "exact_formula": sign + FORMULAS["exact"],
    }
