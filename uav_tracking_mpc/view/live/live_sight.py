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

"""What there is to see of an aircraft from what is heard of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit, orbit_about
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.flight_watcher import CONTROLLER
from uav_tracking_mpc.nodes.heard_aircraft import HeardAircraft, Report
from uav_tracking_mpc.nodes.newest_message import NewestMessage
from uav_tracking_mpc.nodes.reported_orbit import reported_orbit
from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY
from uav_tracking_mpc.nodes.tracking_message import ERRORS, TARGET, WIND, told_mode
from uav_tracking_mpc.view.sight import NodeStatus, Sight, TargetSight

T = TypeVar("T")
STALE = 1.5  # s of wall time after which what comes many times a second counts as silent
LATE_REPORT = 2.5  # s after which a node may no longer be as it said: it reports once a second
GONE = 5.0  # s after which a node counts as silent
SILENT = 3  # level of a node


def live_sight(
    heard: HeardAircraft, before: Sight | None, statuses: tuple[NodeStatus, ...], now: float
) -> Sight | None:
    """What there is to see now.

    Args:
        heard: What the aircraft, its controller and its target said.
        before: What was seen before; it stays where nothing new comes.
        statuses: What the nodes say of themselves.
        now: Steady time in [s].

    Returns:
        None before the first state.
    """
    state = _fresh(heard.state, now)
    if state is not None:
        return _seen(heard, state, statuses, now)
    if before is None:
        return None
    # The controller knows whether time stands still or the state is lost.
    report = heard.reports.get(CONTROLLER)
    mode, reason = FallbackMode.SILENCE, heard.state.trouble
    if not reason:
        reason = f"nothing comes on {ODOMETRY.name} for {now - heard.state.arrival:.0f} s"
    if report is not None and now - report.arrival <= LATE_REPORT:
        mode, reason = _named_mode(report) or mode, report.words
    return replace(before, mode=mode, reason=reason, plan=None, flown=None, statuses=statuses)


def node_statuses(heard: HeardAircraft, now: float) -> tuple[NodeStatus, ...]:
    """What the nodes of an aircraft say of themselves; those that say no more are silent.

    Args:
        heard: Of the aircraft.
        now: Steady time in [s].
    """
    return tuple(
        NodeStatus(report.node, SILENT, f"silent, before: {report.words}", report.values)
        if now - report.arrival > GONE
        else NodeStatus(report.node, report.level, report.words, report.values)
        for report in heard.reports.values()
    )


def _seen(
    heard: HeardAircraft, state: Measurement, statuses: tuple[NodeStatus, ...], now: float
) -> Sight:
    figures = _fresh(heard.figures, now) or {}
    airspeed = _fresh(heard.airspeed, now)
    orbit = _fresh(heard.orbit, now)
    report = heard.reports.get(CONTROLLER)
    target = _target(heard, figures, orbit, now)
    mode, reason = _mode(heard, figures, now)
    speed = math.hypot(*state.ground_velocity) if airspeed is None else airspeed
    return Sight(
        time=state.stamp,
        position=state.position,
        heading=state.heading,
        path_angle=state.path_angle,
        bank=bank_from_turn_rate(state.turn_rate, speed),
        airspeed=_number(airspeed),
        ground_velocity=state.ground_velocity,
        wind=_wind(figures, state, airspeed),
        target=target,
        wanted=_wanted(target, report),
        flown=orbit,
        plan=_plan(heard, state.stamp, now),
        mode=mode,
        reason=reason,
        errors={name: figures[name] for name in ERRORS if name in figures},
        cost=_number(_fresh(heard.cost, now)),
        solve_time=_number(_fresh(heard.solve_time, now)),
        latency=_latency(report),
        statuses=statuses,
    )


def _mode(
    heard: HeardAircraft, figures: Mapping[str, float], now: float
) -> tuple[FallbackMode | None, str]:
    """What is flown, and why nothing better is."""
    report, silence = heard.reports.get(CONTROLLER), now - heard.plan.arrival
    said = None
    if report is not None and now - report.arrival <= LATE_REPORT:
        said = _named_mode(report)
    why = "" if report is None or said is None else report.values.get("mode reason", "")
    if silence > STALE:
        if said is FallbackMode.SILENCE or math.isinf(silence):
            return (None if math.isinf(silence) else FallbackMode.SILENCE), why
        return FallbackMode.SILENCE, f"nothing comes on {COMMAND.name} for {silence:.0f} s"
    # With each command comes its mode, but for those without a target.
    mode = told_mode(figures.get("mode", math.nan)) or said
    return mode, why if mode is said else ""


def _target(
    heard: HeardAircraft, figures: Mapping[str, float], orbit: FlownOrbit | None, now: float
) -> TargetSight | None:
    """Where the target is estimated, measured and is; where it was measured last stays."""
    measured: NDArray[np.float64] | None = heard.sighting.value
    tracked, truth = heard.tracked.value, _fresh(heard.truth, now)
    if tracked is not None and heard.tracked.arrival >= heard.sighting.arrival:
        measured = tracked.position
    if all(name in figures for name in TARGET):
        position = np.array([figures[name] for name in TARGET])
        velocity = None if orbit is None else orbit.velocity  # the target carries the orbit along
        std = figures.get("target_std", math.nan)
        return TargetSight(position, velocity, std, measured, truth)
    known = truth if measured is None else measured
    return None if known is None else TargetSight(known, measured=measured, truth=truth)


def _plan(heard: HeardAircraft, time: float, now: float) -> NDArray[np.float64] | None:
    """What is left of the plan at a time of the flight in [s]."""
    plan = _fresh(heard.plan, now)
    if plan is None or not len(plan.positions):
        return None
    return plan.positions[plan.times >= time - plan.stamp]


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


def _wanted(target: TargetSight | None, report: Report | None) -> FlownOrbit | None:
    orbit = None if report is None else reported_orbit(report.values)
    if target is None or orbit is None:
        return None
    velocity = np.zeros(3) if target.velocity is None else target.velocity
    return orbit_about(target.position, velocity, orbit)


def _named_mode(report: Report) -> FallbackMode | None:
    try:
        return FallbackMode(report.values.get("mode"))
    except ValueError:
        return None


def _latency(report: Report | None) -> float:
    try:
        return math.nan if report is None else float(report.values.get("latency [s]", "nan"))
    except ValueError:
        return math.nan


def _fresh(message: NewestMessage[T], now: float) -> T | None:
    """What a message says, while others come."""
    return message.value if now - message.arrival <= STALE else None


def _number(value: float | None) -> float:
    return math.nan if value is None else value
