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

"""What there is to see of an aircraft, built from what is known of it, measured or published."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.orbit import FlownOrbit, Orbit, orbit_about
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.diagnostic_values import reported_mode, reported_orbit
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS, TARGET, WIND, told_mode
from uav_tracking_mpc.nodes.topics import COMMAND
from uav_tracking_mpc.view.watched_flight import Sight, TargetSight

CARRIED = 2.0  # s, bound: figures that are older or newer than the state are of another time


def sight_of(
    time: float,
    state: Measurement,
    airspeed: float | None,
    target: TargetSight | None,
    asked: Orbit | None,
    **rest: Any,
) -> Sight:
    """A sight of a state.

    Args:
        time: Of the flight's clock in [s].
        state: Of the aircraft at that time.
        airspeed: In [m/s]; None where it is not known.
        target: None where it is not known.
        asked: The orbit that is asked for; None where that is not known.
        rest: Of the sight, by name.
    """
    wanted: FlownOrbit | None = None
    if target is not None and asked is not None:
        velocity = np.zeros(3) if target.velocity is None else target.velocity
        wanted = orbit_about(target.position, velocity, asked)
    speed = math.hypot(*state.ground_velocity) if airspeed is None else airspeed
    return Sight(
        time=time,
        position=state.position,
        heading=state.heading,
        path_angle=state.path_angle,
        bank=bank_from_turn_rate(state.turn_rate, speed),
        airspeed=number(airspeed),
        ground_velocity=state.ground_velocity,
        target=target,
        wanted=wanted,
        **rest,
    )


def heard_sight(
    time: float,
    state: Measurement,
    airspeed: float | None,
    figures: Mapping[str, float],
    orbit: FlownOrbit | None,
    seen: tuple[NDArray[np.float64] | None, NDArray[np.float64] | None],
    values: Mapping[str, str],
    **rest: Any,
) -> Sight:
    """A sight of what an aircraft, its controller and its target published.

    Args:
        time: Of the flight's clock in [s].
        state: Of the aircraft at that time.
        airspeed: In [m/s]; None where it is not known.
        figures: What the controller tracks by, by name: see ``tracking_message``.
        orbit: On which the plan ends; None where there is none.
        seen: Where the target was measured last, and where it truly is; None for unknown.
        values: Diagnostics of the controller.
        rest: Of the sight, by name.
    """
    measured, truth = seen
    target: TargetSight | None = None
    if all(name in figures for name in TARGET):
        position, velocity = np.array([figures[name] for name in TARGET]), None
        if orbit is not None:
            velocity = orbit.velocity  # the target carries the orbit along
            # States come more often than figures: beside a newer one it would lie behind.
            age = state.stamp - figures["stamp"]
            position += velocity * (age if abs(age) <= CARRIED else 0.0)
        target = TargetSight(
            position, velocity, figures.get("target_std", math.nan), measured, truth
        )
    elif (known := truth if measured is None else measured) is not None:
        target = TargetSight(known, measured=measured, truth=truth)
    return sight_of(
        time,
        state,
        airspeed,
        target,
        reported_orbit(values),
        flown=orbit,
        wind=_wind(figures, state, airspeed),
        errors={name: figures[name] for name in ERRORS if name in figures},
        **rest,
    )


def flown_mode(
    silence: float, patience: float, figures: Mapping[str, float], values: Mapping[str, str]
) -> tuple[FallbackMode | None, str]:
    """What is flown, and why nothing better is; None before the first command.

    Args:
        silence: Since the last command in [s]; infinite before the first.
        patience: After which commands count as missing in [s].
        figures: What the controller tracks by, by name.
        values: Diagnostics of the controller.
    """
    said, why = reported_mode(values) or (None, "")
    if silence <= patience:
        # With each command comes its mode, but for those without a target.
        mode = told_mode(figures.get("mode", math.nan)) or said
        return mode, why if mode is said else ""
    if math.isinf(silence):
        return None, why
    if said is FallbackMode.SILENCE:
        return said, why
    return FallbackMode.SILENCE, f"nothing comes on {COMMAND.name} for {silence:.0f} s"


def number(value: float | None) -> float:
    """A value, nan where it is not known.

    Args:
        value: In any unit [-].
    """
    return math.nan if value is None else value


def _wind(
    figures: Mapping[str, float], state: Measurement, airspeed: float | None
) -> NDArray[np.float64] | None:
    """As the controller estimates it, else that of the wind triangle, v_ground - v_air."""
    if all(name in figures for name in WIND):
        return np.array([figures[name] for name in WIND])
    if airspeed is None:
        return None
    through_air = air_velocity(state.heading, state.path_angle, airspeed, math)
    return state.ground_velocity - np.array(through_air)
