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

"""A flight as its bag tells it: its log, and what its nodes complained of last."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.flight_path import FlightPath
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import (
    nanoseconds,
    plan_from_command,
    truth_from_odometry,
)
from uav_tracking_mpc.nodes.messages.diagnostic_values import (
    ERROR,
    REASON,
    STALE,
    WARN,
    mode_changes,
    orbit_changes,
    reported_mode,
    reported_orbit,
    sensor_changes,
    with_silences,
)
from uav_tracking_mpc.nodes.messages.heard_values import VALUES, NodeReport
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    Topic,
)
from uav_tracking_mpc.report import bag
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog, Latency, LinkFigures
from uav_tracking_mpc.simulation.motions import motion_of

NOT_RECORDED = 0.1  # -, share of the commands that a bag may lack


def airspeeds(
    flown: Sequence[tuple[int, Measurement]], measured: Sequence[tuple[int, float]]
) -> NDArray[np.float64]:
    """Airspeed at each state, shape (n,), in [m/s]; of still air where none was measured.

    Args:
        flown: Stamp in [ns] and motion of each state.
        measured: Stamp in [ns] and airspeed in [m/s] of each air velocity.
    """
    if not measured:
        return np.array([np.linalg.norm(motion.ground_velocity) for _, motion in flown])
    stamps, speeds = zip(*sorted(measured), strict=True)
    first = stamps[0]  # differences keep their nanoseconds as floats
    return np.interp(
        [stamp - first for stamp, _ in flown], [stamp - first for stamp in stamps], speeds
    )


def through_the_air(
    told: Sequence[tuple[int, Measurement]], measured: Sequence[tuple[int, float]]
) -> list[tuple[int, Measurement]]:
    """The path through the air at each state, with its airspeed, as the controller finds it.

    Args:
        told: Stamp in [ns] and motion of each state, from before the flight on.
        measured: Stamp in [ns] and airspeed in [m/s] of each air velocity.
    """
    told = sorted(told, key=lambda each: each[0])
    path, speeds = FlightPath(), airspeeds(told, measured).tolist()
    return [
        (stamp, replace(path.of(motion, speed), airspeed=speed))
        for (stamp, motion), speed in zip(told, speeds, strict=True)
    ]


def latency(
    states: Sequence[tuple[int, int]], commands: Sequence[tuple[int, int]]
) -> Latency | None:
    """From a state on the wire to the command computed from it, as the recorder heard them.

    A command bears the stamp of its state. Simulated stamps are not wall time: the times at which
    the recorder heard state and command are compared instead.

    Args:
        states: Stamp in [ns] of each state and wall time in [ns] at which it was heard.
        commands: The same of each command.

    Returns:
        The figures in [us]; None where no command answers a recorded state.
    """
    arrival = dict(states)
    delays = [(time - arrival[stamp]) * 1e-3 for stamp, time in commands if stamp in arrival]
    if not delays:
        return None
    median, p99 = np.percentile(delays, [50.0, 99.0])
    return Latency(median=float(median), p99=float(p99), max=float(max(delays)))


def beside_commands(
    sent: Sequence[int], values: Sequence[tuple[int, float]]
) -> NDArray[np.float64]:
    """Values in the order of the commands: each was sent right after its command.

    Args:
        sent: Wall time in [ns] at which each command was heard.
        values: Wall time in [ns] at which each value was heard, and the value.

    Returns:
        One value a command, shape (n,); nan where none was heard.
    """
    beside = np.full(len(sent), np.nan)
    for time, value in values:
        index = int(np.searchsorted(sent, time, side="right")) - 1
        if index >= 0:
            beside[index] = value
    return beside


def link_figures(link: dict[str, str]) -> LinkFigures:
    """What a link measured.

    Args:
        link: The last values of its diagnostics, by name.
    """
    return LinkFigures(
        dialect=link["dialect"],
        rate=float(link.get("rate [Hz]", "nan")),
        latency=float(link.get("latency median [ms]", "nan")),
        latency_p99=float(link.get("latency p99 [ms]", "nan")),
        lost=int(link.get("messages lost", 0)),
        refused=int(link.get("commands refused", 0)) + int(link.get("plans refused", 0)),
    )


Truth = tuple[int, NDArray[np.float64], NDArray[np.float64]]  # stamp [ns], place [m], speed [m/s]


class FlownTarget(NamedTuple):
    """A target at the times of a flight's states.

    Attributes:
        position: In ``map``, shape (n, 3), in [m].
        velocity: In ``map``, shape (n, 3), in [m/s].
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]


def simulated_target(
    parameters: TargetParameters, began: int, stamps: Sequence[int], truths: Sequence[Truth] = ()
) -> FlownTarget:
    """The true motion of a target that was simulated: as it told, for it may have been steered.

    Args:
        parameters: Of its motion at the start, which counts where it told nothing.
        began: When the motion began in [ns].
        stamps: Times asked for in [ns].
        truths: What it told.
    """
    if truths:
        return _told_target(truths, stamps)
    motion, times = motion_of(parameters), [(stamp - began) * 1e-9 for stamp in stamps]
    return FlownTarget(
        np.array([motion.position(time) for time in times]).reshape(-1, 3),
        np.array([motion.velocity(time) for time in times]).reshape(-1, 3),
    )


def sighted_target(
    sightings: Sequence[tuple[int, NDArray[np.float64]]], stamps: Sequence[int]
) -> FlownTarget:
    """The motion of a target that told its positions, interpolated.

    Args:
        sightings: Stamps in [ns] and positions, shape (3,), in [m].
        stamps: Times asked for in [ns].

    Raises:
        ValueError: There is no sighting.
    """
    if not sightings:
        raise ValueError("the bag holds no position of the target")
    times, places, wanted = _timed(sightings, stamps)
    speeds = np.gradient(places, times, axis=0) if len(times) > 1 else np.zeros_like(places)
    return FlownTarget(
        np.column_stack([np.interp(wanted, times, axis) for axis in places.T]),
        np.column_stack([np.interp(wanted, times, axis) for axis in speeds.T]),
    )


def _timed(
    told: Sequence[tuple[int, NDArray[np.float64]]], stamps: Sequence[int]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """When and what was told, in order of time, and the times asked for, since the first [s]."""
    first = told[0][0]  # differences keep their nanoseconds as floats
    values = {(stamp - first) * 1e-9: value for stamp, value in told}
    times = sorted(values)
    wanted = np.array([(stamp - first) * 1e-9 for stamp in stamps])
    return np.array(times), np.array([values[time] for time in times]), wanted


def _told_target(told: Sequence[Truth], stamps: Sequence[int]) -> FlownTarget:
    """Cubic Hermite interpolation; before the first and after the last it moves straight on."""
    motions = [(stamp, np.array(motion)) for stamp, *motion in told]
    times, known, wanted = _timed(motions, stamps)
    places, velocities = np.moveaxis(known, 1, 0)
    inside = np.clip(wanted, times[0], times[-1])
    if len(times) == 1:
        position = np.tile(places[0], (len(wanted), 1))
        velocity = np.tile(velocities[0], (len(wanted), 1))
    else:
        curve = CubicHermiteSpline(times, places, velocities)
        position, velocity = curve(inside), curve(inside, 1)
    return FlownTarget(position + velocity * (wanted - inside)[:, np.newaxis], velocity)


def messages(path: Path, *topics: Topic) -> Iterator[tuple[Topic, int, Any]]:
    """Messages of a bag, in the order in which they were heard.

    Args:
        path: Of the bag.
        topics: Of which messages are wanted.

    Yields:
        (topic, time in [ns] at which it was heard, message) of each.
    """
    wanted = {f"/{topic.name.lstrip('/')}": topic for topic in topics}
    for name, time, message in bag.messages(path, wanted):
        yield wanted[name], time, message


class _Said(NamedTuple):
    """What a message says: when it was heard and stamped in [ns], and its value."""

    heard: int
    stamp: int
    value: Any


def _series(path: Path) -> tuple[dict[str, list[_Said]], int]:
    """What the messages of each topic say, and how many cannot be used: not finite, absurd."""
    series: dict[str, list[_Said]] = {topic.name: [] for topic in READ}
    unusable = 0
    for topic, heard, message in messages(path, *READ):
        stamp = nanoseconds(message.header.stamp) if hasattr(message, "header") else heard
        try:
            series[topic.name].append(_Said(heard, stamp, READ[topic](message)))
        except ValueError:
            unusable += 1
    return series, unusable


def flight_log(path: Path, configuration: Configuration) -> FlightLog:
    """Record of a flight from its bag; time counts from the first command.

    With a real autopilot it counts from when that was engaged. The vehicle's motion is as measured;
    the target's is the true one, or what a target over MAVLink said of itself. A bag without
    ``uav/air_velocity`` is read as flown in still air.

    Args:
        path: Of the bag.
        configuration: What was flown.

    Raises:
        ValueError: The bag holds no command, none was flown, or it holds no state meanwhile.
    """
    series, unusable = _series(path)
    states, commands = series[ODOMETRY.name], series[COMMAND.name]
    reports = [(each.stamp, said) for each in series[DIAGNOSTICS.name] for said in each.value]
    latest = {said.node: said.values for _, said in reports}
    if not commands:
        raise ValueError(f"bag {path} holds no command: the controller never flew")
    start, link = commands[0].stamp, latest.get("autopilot_link")
    if link is not None:
        engaged = [each.heard for each in series[ENGAGED.name] if each.value]
        if not engaged:
            raise ValueError(f"bag {path} holds no flown command: the autopilot was never engaged")
        start = engaged[0]
    end = start + round(configuration.mission.duration * 1e9)
    through_air = [(each.stamp, each.value) for each in series[AIR_VELOCITY.name]]
    paths = through_the_air([(each.stamp, each.value) for each in states], through_air)
    flown = [(stamp, motion) for stamp, motion in paths if start <= stamp <= end]
    if not flown:
        raise ValueError(f"bag {path} holds no state of the aircraft while commands were flown")
    sent = [each for each in commands if start <= each.stamp <= end]
    # An interrupted flight is as long as it was flown; a whole one may lack its last state.
    span = (flown[-1][0] - start) * 1e-9
    span += 1.0 / configuration.simulator.state_rate
    controller, simulator = (latest.get(node, {}) for node in ("nmpc_controller", "uav_simulator"))
    tracking, stamps = configuration.controller, [stamp for stamp, _ in flown]
    if link is not None and configuration.link.target_system:
        seen = sorted((*series[TARGET.name], *series[TARGET_ODOMETRY.name]), key=lambda s: s.heard)
        target = sighted_target([(each.stamp, each.value) for each in seen], stamps)
    else:
        began = int(latest.get("target_publisher", {}).get("began [ns]", 0))
        truths = [each.value for each in series[TARGET_TRUTH.name]]
        target = simulated_target(configuration.target, began, stamps, truths)
    # With the nearest direction asked for, the controller tells which one it chose.
    direction = controller.get("direction", tracking.orbit.direction)
    asked = ((stamp, reported_orbit(said.values)) for stamp, said in reports)
    orbits = orbit_changes([(stamp, orbit) for stamp, orbit in asked if orbit is not None], start)
    told = ((stamp, reported_mode(said.values)) for stamp, said in reports)
    modes = [(stamp, *mode) for stamp, mode in told if mode is not None]
    unplanned = (
        int(controller.get(f"mode {mode.value}", 0))
        for mode in (FallbackMode.LOITER, FallbackMode.HOLD)
    )
    vehicle = [motion.state(motion.airspeed or 0.0) for _, motion in flown]
    cost, solve_time = (
        beside_commands(
            [each.heard for each in sent],
            [(each.heard, each.value) for each in series[TRACKING[name].name]],
        )
        for name in ("cost", "solve_time")
    )
    banks = np.array([motion.bank or 0.0 for _, motion in flown])
    return FlightLog(
        config=configuration.name,
        duration=min(configuration.mission.duration, span),
        speed=float(simulator.get("speed", configuration.mission.speed)),
        model=tracking.model,
        plant=configuration.simulator.plant if link is None else configuration.link.link,
        orbit=orbits[-1][1] if orbits else replace(tracking.orbit, direction=direction),
        orbits=orbits,
        input_lower=tracking.input_lower,
        input_upper=tracking.input_upper,
        time=np.array([(stamp - start) * 1e-9 for stamp, _ in flown]),
        vehicle=np.array(vehicle),
        target=target.position,
        command_time=np.array([(each.stamp - start) * 1e-9 for each in sent]),
        inputs=np.array([each.value for each in sent]),
        cost=cost,
        solve_time=solve_time,
        solver=controller.get("solver", tracking.solver),
        failures=int(controller.get("solver failures", 0)),
        commands=CommandCounts(
            # The last report may be older than the last command, or lost with its node.
            sent=max(int(controller.get("commands sent", 0)), len(sent)),
            late=int(controller.get("commands late", 0)),
            plan_reused=int(controller.get("plan reused", 0)),
            failsafe=int(simulator.get("failsafe", 0)) + sum(unplanned),
        ),
        latency=latency(
            [(each.stamp, each.heard) for each in states],
            [(each.stamp, each.heard) for each in commands],
        ),
        ground_velocity=np.array([motion.ground_velocity for _, motion in flown]),
        target_velocity=target.velocity,
        turn_rate=np.array([motion.turn_rate for _, motion in flown]),
        measured_bank=banks if banks.any() else None,
        unusable=unusable,
        modes=mode_changes(
            with_silences(modes, [each.stamp for each in sent], flown[-1][0]), start, end
        ),
        sensors=sensor_changes(
            [(stamp, said.values) for stamp, said in reports if said.node == "nmpc_controller"],
            start,
            end,
        ),
        tracking=tracking,
        link=None if link is None else link_figures(link),
    )


def not_recorded(path: Path) -> str:
    """That a tenth of the commands or more is not in a bag, in words; or "".

    The figures of a flight count from its first recorded command, when the aircraft may have
    settled already. A recorder that is kept from running for long loses what it could not read.

    Args:
        path: Of the bag.
    """
    sent = recorded = 0
    for topic, _, message in messages(path, COMMAND, DIAGNOSTICS):
        if topic is COMMAND:
            recorded += 1
            continue
        told = [said.values.get("commands sent", 0) for said in READ[topic](message)]
        sent = max([sent, *map(int, told)])
    if sent - recorded < NOT_RECORDED * sent or not sent:
        return ""
    return f"{recorded} of {sent} commands were recorded: the figures leave out the rest"


def last_complaint(path: Path) -> str:
    """The last error that any node reported; without one, a warning that stood at the end; or "".

    What is said after the last state counts for nothing: the nodes end one after the other.

    Args:
        path: Of the bag.
    """
    start: int | None = None
    waiting: list[tuple[int, NodeReport]] = []  # what was said since the latest state
    standing: dict[str, tuple[int, NodeReport]] = {}  # the latest report of each node
    error: tuple[int, NodeReport] | None = None
    for topic, _, message in messages(path, COMMAND, ODOMETRY, DIAGNOSTICS):
        if topic is ODOMETRY:
            for stamp, said in waiting:
                standing[said.path] = stamp, said
                error = (stamp, said) if said.level == ERROR else error
            waiting.clear()
            continue
        stamp = nanoseconds(message.header.stamp)
        if topic is DIAGNOSTICS:
            waiting += [(stamp, said) for said in READ[topic](message) if said.level != STALE]
        elif start is None:
            start = stamp
    warnings = [each for each in standing.values() if each[1].level == WARN]
    last = error or max(warnings, key=lambda each: each[0], default=None)
    if last is None:
        return ""
    stamp, said = last
    reason = said.values.get(REASON, "")
    words = f"{said.words} ({reason})" if reason and reason not in said.words else said.words
    when = "" if start is None else f" at {(stamp - start) * 1e-9:.1f} s"
    return f"{said.path.strip('/')} said{when}: {words}"


READ: dict[Topic, Callable[[Any], Any]] = {
    **{
        topic: VALUES[topic.name]
        for topic in (
            ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, ENGAGED, DIAGNOSTICS,
            TRACKING["cost"], TRACKING["solve_time"],
        )
    },
    TARGET_TRUTH: truth_from_odometry,
    COMMAND: lambda message: plan_from_command(message, ANY_FRAMES)[0][0],
}  # fmt: skip
