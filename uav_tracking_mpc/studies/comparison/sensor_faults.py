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

"""Sensors that fail in flight and targets that are hard to follow, by name: which, when and how.

Every case is a flight of the mismatches' scenario. Nothing is imported here that takes long.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Changes = tuple[tuple[float, str], ...]
BEGIN, END = 120.0, 210.0  # s, of what fails and recovers
STEP = 0.5  # s between changes of what changes all the time
TURN, WIND = 60.0, 8.0  # s, in which the wind turns by a right angle; m/s
SPIKE, SPIKES, JUMP, JUMPS = 10.0, 8.0, 8.0, 6.0  # m and s: of short and of lasting jumps
FROZEN, FLIPPED, OFFSET = 10.0, 0.5, 30.0  # s
HEIGHT_STEP, HEIGHT_STEPS = 3.0, 20.0  # m, s
EIGHT_LENGTH, EIGHT_WIDTH, EIGHT_POINTS = 70.0, 50.0, 60  # m, m, -
EIGHT_SPEED, EIGHT_NOISE = 5.2135, 2.0  # m/s, m: once round in 50 s
UNSEEN = 20.0  # s
CLIMB, DRIFT = 60.0, 0.1  # m, m/s^2
MODERATE = 15.4  # m/s: W20
_SIMULATOR, _CONTROLLER, _TARGET = "uav_simulator", "nmpc_controller", "target_publisher"


@dataclass(frozen=True)
class SensorFault:
    """What fails.

    Attributes:
        overrides: Parameters from the start, by ``SECTION.PARAMETER``.
        changes: Times in [s] and parameters from then on, of a seed and the orbit's altitude [m].
        seeded: Whether the worst of several seeds counts.
    """

    overrides: Mapping[str, object] = field(default_factory=dict)
    changes: Callable[[int, float], Changes] = lambda seed, height: ()
    seeded: bool = False


def _fails(until: float = math.inf, **wrong: object) -> Callable[[int, float], Changes]:
    """Parameters of the simulator that are wrong from the begin on, until they are right again."""
    right = {"airspeed_fault": "none", "airspeed_bias": 0.0, "heading_bias": 0.0}
    right |= {"position_fault": "none", "velocity_gain": 1.0, "position_bias": [0.0, 0.0, 0.0]}
    begun = [(BEGIN, f"{_SIMULATOR}.{name}={value}") for name, value in wrong.items()]
    ended = [(until, f"{_SIMULATOR}.{name}={right[name]}") for name in wrong]
    return lambda seed, height: tuple(begun + ended if math.isfinite(until) else begun)


def _all_the_time(duration: float, change: Callable[[float], str]) -> Changes:
    """What changes from the begin on, by the time since then."""
    return tuple((BEGIN + t, change(float(t))) for t in np.arange(0.0, duration + STEP, STEP))


def _drift(seed: int, height: float) -> Changes:
    rising = _all_the_time(END - BEGIN, lambda t: f"{_SIMULATOR}.airspeed_bias={DRIFT * t:.3f}")
    return (*rising, (END + STEP, f"{_SIMULATOR}.airspeed_bias=0.0"))


def _blocked(seed: int, height: float) -> Changes:
    climb, sink = height + CLIMB, height
    return (
        (BEGIN, f"{_CONTROLLER}.altitude={climb}"),
        *_fails(END, airspeed_fault="blocked")(seed, height),
        (END, f"{_CONTROLLER}.altitude={sink}"),
    )


def _turning_wind(seed: int, height: float) -> Changes:
    def wind(t: float) -> str:
        angle = math.pi / 2.0 * (1.0 + min(t / TURN, 1.0))
        return (
            f"{_SIMULATOR}.wind=[{WIND * math.cos(angle):.4f}, {WIND * math.sin(angle):.4f}, 0.0]"
        )

    return _all_the_time(TURN, wind)


def _displaced(
    seed: int, height: float, size: float, period: float, lasting: Callable[[Any], float]
) -> Changes:
    """Positions off to random sides, from the begin to the end of the flight."""
    random = np.random.default_rng(seed)
    changes: list[tuple[float, str]] = []
    for time in np.arange(BEGIN, 300.0 - period, period):
        angle = random.uniform(-math.pi, math.pi)
        east, north = size * math.cos(angle), size * math.sin(angle)
        changes.append((time, f"{_SIMULATOR}.position_bias=[{east:.4f}, {north:.4f}, 0.0]"))
        if (length := lasting(random)) < period:
            changes.append((time + length, f"{_SIMULATOR}.position_bias=[0.0, 0.0, 0.0]"))
    return tuple(changes)


def _height_steps(seed: int, height: float) -> Changes:
    times = np.arange(BEGIN, 300.0 - HEIGHT_STEPS, HEIGHT_STEPS)
    return tuple(
        (time, f"{_SIMULATOR}.position_bias=[0.0, 0.0, {HEIGHT_STEP * (1 - k % 2)}]")
        for k, time in enumerate(times)
    )


def _figure_of_eight() -> list[float]:
    angles = np.linspace(0.0, 2.0 * math.pi, EIGHT_POINTS, endpoint=False)
    east, north = 0.5 * EIGHT_LENGTH * np.sin(angles), 0.5 * EIGHT_WIDTH * np.sin(2.0 * angles)
    corners = np.column_stack([east, north, np.zeros_like(east)])
    return [float(each) for each in corners.round(3).ravel()]


def _moving(motion: str, **values: object) -> dict[str, object]:
    return {f"{_TARGET}.{name}": value for name, value in {"motion": motion, **values}.items()}


def _unseen(seed: int, height: float) -> Changes:
    return (BEGIN, f"{_TARGET}.dropout=1.0"), (BEGIN + UNSEEN, f"{_TARGET}.dropout=0.0")


SENSOR_FAULTS = {
    "airspeed_plus_3": SensorFault(changes=_fails(airspeed_bias=3.0, airspeed_fault="stuck")),
    "airspeed_at_26": SensorFault(
        {f"{_SIMULATOR}.airspeed_bias": 4.0, f"{_SIMULATOR}.airspeed_fault": "stuck"}
    ),
    "airspeed_stuck_gusts": SensorFault(
        {f"{_SIMULATOR}.gust_intensity": MODERATE}, _fails(airspeed_fault="stuck"), seeded=True
    ),
    "airspeed_drift": SensorFault(changes=_drift),
    "airspeed_zero": SensorFault(changes=_fails(END, airspeed_bias=-50.0)),
    "airspeed_blocked": SensorFault(changes=_blocked),
    "airspeed_none": SensorFault({f"{_SIMULATOR}.airspeed_fault": "silent"}),
    "airspeed_lost": SensorFault(changes=_fails(airspeed_fault="silent")),
    "position_spikes": SensorFault(
        changes=functools.partial(
            _displaced, size=SPIKE, period=SPIKES, lasting=lambda random: random.uniform(0.5, 1.5)
        ),
        seeded=True,
    ),
    "position_jumps": SensorFault(
        changes=functools.partial(
            _displaced, size=JUMP, period=JUMPS, lasting=lambda random: JUMPS
        ),
        seeded=True,
    ),
    "position_offset": SensorFault(changes=_fails(BEGIN + OFFSET, position_bias=[JUMP, 0.0, 0.0])),
    "height_steps": SensorFault(changes=_height_steps),
    "position_frozen": SensorFault(changes=_fails(BEGIN + FROZEN, position_fault="frozen")),
    "position_silent": SensorFault(changes=_fails(BEGIN + FROZEN, position_fault="silent")),
    "heading_30": SensorFault(changes=_fails(heading_bias=math.radians(30.0))),
    "velocity_flip": SensorFault(changes=_fails(BEGIN + FLIPPED, velocity_gain=-1.0)),
    "wind_turns": SensorFault(changes=_turning_wind),
    "figure8_noise": SensorFault(
        _moving("waypoints", waypoints=_figure_of_eight(), speed=EIGHT_SPEED, noise=EIGHT_NOISE)
    ),
    "stop_and_go_8": SensorFault(
        _moving("stop_and_go", speed=8.0, drive_time=12.0, stand_time=18.0)
    ),
    "zigzag_10": SensorFault(_moving("zigzag", drive_time=10.0)),
    "dropout_straight": SensorFault(changes=_unseen),
    "dropout_circling": SensorFault(_moving("circle", radius=80.0, speed=5.0), _unseen),
}
