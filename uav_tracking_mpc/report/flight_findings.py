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

"""What the numbers of a flight say: a verdict in one sentence, and where a range offset is from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.parameters.registry import RELATIVE_MODEL
from uav_tracking_mpc.report.metrics import range_errors
from uav_tracking_mpc.simulation.flight_log import FlightLog

UNITS = {"range": "m", "altitude": "m", "speed": "m/s", "bearing": "rad"}
FALLBACKS = 12  # most that a page lists
LATE_SHARE = 0.01  # of the commands: with more of them a flight is not what was asked for
NOTABLE_OFFSET = 0.01  # mean range error that the report speaks of, [m]


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
    """A flight in three lines: when it settled, how well it held, where the report is.

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
    return [f"settled: {times}", f"last third: {rms}", f"report: {output / 'report.html'}"]


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
    """Whether a flight settled and its commands came in time, but for one in a hundred.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    commands = numbers["commands"]
    return settled(numbers) and commands["late"] <= LATE_SHARE * commands["sent"]


def _band(numbers: dict[str, Any], name: str) -> str:
    return quantity(numbers["settling_bands"][name], UNITS[name], 2)


def verdict(numbers: dict[str, Any]) -> str:
    """One sentence: settled or not, and how well; a second one where something failed.

    Args:
        numbers: What :func:`uav_tracking_mpc.report.metrics.metrics` returned.
    """
    times, steady, final = numbers["settling_s"], numbers["steady_state"], numbers["final"]
    if final["range_error_m"] is None:
        return "No usable record: the last sample of the flight is missing or not finite."
    if settled(numbers):
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
            f"{commands['late']} of {commands['sent']} commands ({share:.1%}) came late."
        )
    if commands["failsafe"]:
        times = "once" if commands["failsafe"] == 1 else f"{commands['failsafe']} times"
        sentences.append(f"The vehicle ran out of plan {times} and held wings level.")
    if unusable := numbers.get("unusable_messages"):
        sentences.append(f"{unusable} messages could not be used and are left out.")
    return sentences


class Fallback(NamedTuple):
    """A time in which something else was flown than was asked for.

    Attributes:
        mode: What was flown, in words.
        begin: In [s] from the start.
        duration: In [s].
        reason: Why, in words.
    """

    mode: str
    begin: float
    duration: float
    reason: str


def fallbacks(log: FlightLog) -> list[Fallback]:
    """The longest times in which the flight fell back, in their order.

    Args:
        log: Record of the flight.
    """
    found = [
        Fallback(flown.mode.value, begin, end - begin, flown.reason)
        for begin, end, flown in log.mode_spans
        if not flown.mode.nominal
    ]
    longest = sorted(found, key=lambda each: each.duration, reverse=True)[:FALLBACKS]
    return sorted(longest, key=lambda each: each.begin)


@dataclass(frozen=True)
class RangeOffset:
    """A standing range error and the turn rates that explain it, or do not.

    Attributes:
        mean: Mean range error over the last third of the flight in [m].
        spread: Half of its peak-to-peak value there in [m].
        from_model: Whether the controller predicted with a steady turn that is not the vehicle's.
        model_turn_rate: u_psi that holds the orbit in the prediction model, in [rad/s].
        exact_turn_rate: u_psi that holds it on the vehicle, in [rad/s].
        model_formula: The first in symbols, empty where there is none to print.
        exact_formula: The second in symbols.
    """

    mean: float
    spread: float
    from_model: bool
    model_turn_rate: float
    exact_turn_rate: float
    model_formula: str
    exact_formula: str


# Section 3.1's steady turns for a clockwise orbit, in symbols.
FORMULAS = {"exact": "v_d / d_d", "paper": "v_d / r_d", "paper9": "v_d r_d / d_d²"}


def range_offset_finding(log: FlightLog) -> RangeOffset | None:
    """The range offset, where there is something to say about it.

    (9) and (11) replace d/r by cos(chi) and z/r by sin(chi), d = sqrt(r^2 - z^2). On the level
    orbit this shifts the turn rate that the controller takes for steady; the feedback makes up for
    the difference, and needs a standing error to do so.

    Args:
        log: Record of the flight.

    Returns:
        None if the model's turn is the plant's and the mean error is at most
        :data:`NOTABLE_OFFSET`, or if nothing was recorded.
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
    return RangeOffset(
        mean=mean,
        spread=0.5 * float(np.ptp(errors)),
        from_model=from_model,
        model_turn_rate=float(steady_inputs(log.model, log.orbit)[0]) if from_model else exact,
        exact_turn_rate=exact,
        model_formula=sign + formula if formula else "",
        exact_formula=sign + FORMULAS["exact"],
    )
