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

"""What nodes say of themselves in /diagnostics: level, words and values, and some of them back.

It needs no ROS: the page of a flight without nodes says the same.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.adaptation import ResponseAdaptation
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.air_estimate import AirEstimate
from uav_tracking_mpc.estimation.response_estimator import CHANNELS
from uav_tracking_mpc.estimation.sensor_health import SensorHealth
from uav_tracking_mpc.simulation.flight_log import FlownMode, SensorNews
from uav_tracking_mpc.simulation.plan_follower import PlanFollower
from uav_tracking_mpc.simulation.steered_target import SteeredTarget

OK, WARN, ERROR, STALE = range(4)  # levels of diagnostic_msgs
AXES = ("east", "north", "up")
CEASED = 1_000_000_000  # ns after the last command, in which a controller says why there is none


def controller_status(mode: FallbackMode, reason: str, flying: bool) -> tuple[int, str, str]:
    """Level and words of a controller, and why, where the words do not say it.

    Args:
        mode: What it commands.
        reason: Why nothing better, in words.
        flying: Whether it has sent a command.
    """
    if mode is FallbackMode.SILENCE:
        return ERROR if flying else WARN, f"{reason}: no command is sent", ""
    if mode is FallbackMode.HOLD:
        return ERROR, f"{reason}: wings level", ""
    if mode.nominal:
        return OK, f"tracking: {mode.value}", ""
    level = WARN if mode.planned else ERROR
    return level, f"flying {mode.value}", reason


def vehicle_status(plan: PlanFollower) -> tuple[int, str]:
    """Level and words of a simulated vehicle.

    Args:
        plan: That it flies.
    """
    if not plan.commanded:
        return WARN, "waiting for the first command"
    if plan.holding:
        return WARN, "no plan left to fly: holding wings level until a command comes"
    return OK, "flying on commands"


def target_words(target: SteeredTarget, now: float) -> str:
    """How a simulated target moves.

    Args:
        target: That moves.
        now: Its time in [s].
    """
    motion, place = target.parameters.motion, target.heading_for(now)
    if place is None:
        return f"target is {motion}"
    x, y, z = place.tolist()
    return f"target drives to ({x:.6g}, {y:.6g}, {z:.6g}), then is {motion}"


def air_values(air: AirEstimate) -> dict[str, object]:
    """Keys, with units, and values of wind, biases and sensors.

    Args:
        air: What is known of them.
    """
    state = air.state
    vectors = {"mean wind": state.wind, "gust": state.gust, "bias of ground velocity": state.bias}
    return {
        **{
            f"{name} {axis} [m/s]": value
            for name, vector in vectors.items()
            for axis, value in zip(AXES, vector.tolist(), strict=True)
        },
        "airspeed reads too much by [%]": 100.0 * float(state.alpha[0]),
        "bias of heading [deg]": math.degrees(state.beta[0]),
        **air.health.values(),
    }


def estimated_values(
    drift: NDArray[np.float64], air: AirEstimate | None, estimating: bool
) -> dict[str, object]:
    """Keys, with units, and values of the drift and what is known of the air.

    Args:
        drift: Wind less the target's velocity, shape (3,), in [m/s].
        air: With wind, biases and sensors; None where they are not estimated.
        estimating: Whether it goes on: else no number is shown, for 0 would be still air.
    """
    values: dict[str, object] = {
        f"drift {axis} [m/s]": value for axis, value in zip(AXES, drift.tolist(), strict=True)
    }
    if air is not None:
        values |= air_values(air)
    if estimating:
        return values
    return {key: "unknown" if isinstance(value, float) else value for key, value in values.items()}


def response_values(response: ResponseAdaptation) -> dict[str, object]:
    """Keys, with units, and values: estimates with standard deviations, and what is flown by.

    Args:
        response: Of the controller.
    """
    values: dict[str, object] = {}
    lags, dead_times, gains = response.flown
    for axis, (name, channel) in enumerate(zip(CHANNELS, response.estimator.channels, strict=True)):
        if response.enabled:
            values |= {
                f"{name} lag estimated [s]": channel.lag,
                f"{name} lag deviation [s]": channel.lag_deviation,
                f"{name} dead time estimated [s]": channel.dead_time,
                f"{name} dead time deviation [s]": channel.dead_time_deviation,
                f"{name} lag and dead time estimated [s]": channel.delay,
                f"{name} lag and dead time deviation [s]": channel.delay_deviation,
                f"{name} gain estimated": channel.gain,
                f"{name} gain deviation": channel.gain_deviation,
                f"{name} response trusted": channel.trusted,
                f"{name} gain trusted": channel.gain_trusted,
            }
        values |= {
            f"{name} lag flown by [s]": float(lags[axis]),
            f"{name} dead time flown by [s]": float(dead_times[axis]),
            f"{name} gain flown by": float(gains[axis]),
        }
    for axis in range(2):
        values[f"limit cycle of the {CHANNELS[axis]}"] = response.oscillation.words(axis)
    return values


MODE, REASON = "mode", "mode reason"


def reported_mode(values: Mapping[str, str]) -> tuple[FallbackMode, str] | None:
    """Mode of a report and why it is none better; None where it tells none.

    Args:
        values: Of the diagnostics of a controller.
    """
    try:
        return FallbackMode(values[MODE]), values.get(REASON, "")
    except (KeyError, ValueError):
        return None


def mode_changes(
    reports: Sequence[tuple[int, FallbackMode, str]], start: int, end: int
) -> tuple[FlownMode, ...]:
    """When which mode was flown.

    Args:
        reports: Stamp in [ns], mode and reason of each report, in order.
        start: Of the flight in [ns]; the first report after it tells the mode since then.
        end: Of the flight in [ns]; later reports do not count.

    Returns:
        The first mode and each that differs from the one before, times since the start.
    """
    changes: list[FlownMode] = []
    for stamp, mode, reason in reports:
        if start <= stamp <= end and (not changes or changes[-1].mode is not mode):
            changes.append(FlownMode((stamp - start) * 1e-9 if changes else 0.0, mode, reason))
    return tuple(changes)


def with_silences(
    reports: Sequence[tuple[int, FallbackMode, str]], commands: Sequence[int], end: int
) -> list[tuple[int, FallbackMode, str]]:
    """Adds what a controller that is gone cannot report: that no command came.

    Args:
        reports: As of :func:`mode_changes`.
        commands: Stamps of the commands in [ns], in order.
        end: Of the flight in [ns].
    """
    told, stamps = list(reports), [stamp for stamp, *_ in reports]
    for last, after in pairwise([*commands, end]):
        known = bisect_right(stamps, last + CEASED)
        if after - last <= CEASED or not known or reports[known - 1][1] is FallbackMode.SILENCE:
            continue
        told.append((last, FallbackMode.SILENCE, "no command came"))
        if after < end:
            told.append((after, *reports[bisect_right(stamps, after) - 1][1:]))
    return sorted(told, key=lambda report: report[0])


def sensor_changes(
    reports: Sequence[tuple[int, Mapping[str, str]]], start: int, end: int
) -> tuple[SensorNews, ...]:
    """When which sensor was left out or used again.

    Args:
        reports: Stamp in [ns] and values of each report of a controller, in order.
        start: Of the flight in [ns]; earlier reports do not count.
        end: Of the flight in [ns]; later reports do not count.
    """
    states, changes = SensorHealth().states, list[SensorNews]()
    for stamp, values in reports:
        for name, before in states.items():
            state = values.get(f"{name} sensor", before)
            if state != before and start <= stamp <= end:
                changes.append(SensorNews((stamp - start) * 1e-9, name, state))
                states[name] = state
    return tuple(changes)


RANGE, ALTITUDE, AIRSPEED = "orbit range [m]", "orbit altitude [m]", "orbit airspeed [m/s]"
DIRECTION = "direction"


def orbit_values(orbit: Orbit) -> dict[str, object]:
    """Keys, with units, and values, to the last digit.

    Args:
        orbit: That is asked for.
    """
    numbers = {RANGE: orbit.range, ALTITUDE: orbit.altitude, AIRSPEED: orbit.speed}
    return {**{key: repr(value) for key, value in numbers.items()}, DIRECTION: orbit.direction}


def reported_orbit(values: Mapping[str, str]) -> Orbit | None:
    """The orbit of a report; None where it holds none.

    Args:
        values: Of the diagnostics of a controller.
    """
    try:
        range_, altitude, speed = (float(values[key]) for key in (RANGE, ALTITUDE, AIRSPEED))
        return Orbit(range_, altitude, speed, values[DIRECTION])
    except (KeyError, ValueError):
        return None


def orbit_changes(
    reports: Sequence[tuple[int, Orbit]], start: int
) -> tuple[tuple[float, Orbit], ...]:
    """When which orbit was asked for.

    Args:
        reports: Stamp in [ns] and orbit of each report, in order.
        start: Of the flight in [ns]; the first report after it tells the orbit since then.

    Returns:
        Time since the start in [s] and orbit of the first and of each that differs from the last.
    """
    changes: list[tuple[float, Orbit]] = []
    for stamp, orbit in reports:
        if stamp >= start and (not changes or changes[-1][1] != orbit):
            changes.append(((stamp - start) * 1e-9, orbit))
    return tuple(changes)
