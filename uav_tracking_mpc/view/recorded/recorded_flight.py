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

"""One aircraft of a bag: what there is to see of it at a time of the record."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit, orbit_about
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.reported_orbit import reported_orbit
from uav_tracking_mpc.nodes.tracking_message import ERRORS, WIND, told_mode
from uav_tracking_mpc.nodes.tracking_message import TARGET as TRACKED
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.recorded.recorded_figures import (
    AIR_VELOCITY,
    COMMAND,
    COST,
    DIAGNOSTICS,
    ODOMETRY,
    ORBIT,
    SOLVE_TIME,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING_ERRORS,
    RecordedFigures,
)
from uav_tracking_mpc.view.recorded.recorded_statuses import RecordedStatuses, reported_mode
from uav_tracking_mpc.view.recorded.recorded_time import Moment, RecordedTime
from uav_tracking_mpc.view.recorded.recorded_topic import SECOND, Place, RecordedTopic
from uav_tracking_mpc.view.sight import Sight, TargetSight
from uav_tracking_mpc.view.steering import CONTROLLER
from uav_tracking_mpc.view.watched_flight import WatchedFlight

PAST_PERIOD = 0.2  # s
PAST_KEPT = 2000  # sights
UNANSWERED = SECOND  # ns of flight after which what a controller sent counts no longer


class RecordedFlight(WatchedFlight):
    """Shows what was recorded of an aircraft at the time of a clock.

    Args:
        namespace: Without slashes around it; empty for none.
        topics: Of the aircraft, by their names without the namespace.
        time: Of the record; its clock is followed.
        tracking: What its controller flew by; None where nobody knows.
    """

    def __init__(
        self,
        namespace: str,
        topics: Mapping[str, RecordedTopic],
        time: RecordedTime,
        tracking: TrackingParameters | None,
    ) -> None:
        self.name = namespace.replace("/", "_") or "uav"
        self._topics, self._time, self._tracking = topics, time, tracking
        self._figures = figures = RecordedFigures(topics)
        self._past: OrderedDict[int, Sight | None] = OrderedDict()
        self._statuses: RecordedStatuses | None = None
        if DIAGNOSTICS in topics:
            self._statuses = RecordedStatuses(
                topics[DIAGNOSTICS], namespace, lambda place: figures.of(DIAGNOSTICS, place) or ()
            )

    @property
    def sight(self) -> Sight | None:
        """What there is to see at the time of the clock."""
        return self.at(self._time.clock.time)

    @property
    def tracking(self) -> TrackingParameters | None:
        """What its controller flew by; None where nobody knows."""
        return self._tracking

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`; plans and statuses are left out.

        Args:
            span: How far back from now in [s].
        """
        now = self._time.clock.time
        last = math.floor(now / PAST_PERIOD)
        first = math.ceil(max(now - span, self._time.clock.begin) / PAST_PERIOD)
        sights: list[Sight] = []
        for number in range(first, last + 1):
            if number not in self._past:
                self._past[number] = self.at(number * PAST_PERIOD, whole=False)
            sight = self._past[number]
            if sight is not None and (not sights or sight.time > sights[-1].time):
                sights.append(sight)
        while len(self._past) > max(PAST_KEPT, last - first + 1):
            self._past.popitem(last=False)
        return sights

    def at(self, time: float, whole: bool = True) -> Sight | None:
        """What there was to see at a time; None before the first state.

        Args:
            time: In [s] of the record.
            whole: With plan and statuses, which take long to read.
        """
        odometry = self._topics[ODOMETRY]
        place = self._time.newest(odometry, time)
        motion: Measurement | None = self._figures.of(ODOMETRY, place)
        while place is not None and motion is None:  # that one was no state
            place = odometry.before(place)
            motion = self._figures.of(ODOMETRY, place)
        if place is None or motion is None:
            return None
        moment = self._time.moment(odometry, place)
        airspeed: float | None = self._beside(AIR_VELOCITY, moment)
        speed = math.hypot(*motion.ground_velocity) if airspeed is None else airspeed
        figures: Mapping[str, float] = self._beside(TRACKING_ERRORS, moment) or {}
        values: Mapping[str, str] = {}
        statuses = {}
        if self._statuses is not None:
            status = self._statuses.of(CONTROLLER, moment.heard)
            values = values if status is None else status.values
            statuses = self._statuses.at(moment.heard) if whole else {}
        flown: FlownOrbit | None = self._beside(ORBIT, moment)
        target, asked = self._target(moment, figures, flown), reported_orbit(values)
        wanted: FlownOrbit | None = None
        if target is not None and asked is not None:
            moves = np.zeros(3) if target.velocity is None else target.velocity
            wanted = orbit_about(target.position, moves, asked)
        mode, reason = self._mode(moment, figures, values)
        return Sight(
            time=self._time.seconds(moment),
            position=motion.position,
            heading=motion.heading,
            path_angle=motion.path_angle,
            bank=bank_from_turn_rate(motion.turn_rate, speed),
            airspeed=math.nan if airspeed is None else airspeed,
            ground_velocity=motion.ground_velocity,
            wind=_wind(figures, motion, airspeed),
            target=target,
            wanted=wanted,
            flown=flown,
            plan=self._beside(COMMAND, moment) if whole else None,
            mode=mode,
            reason=reason,
            errors={name: figures[name] for name in ERRORS if name in figures},
            cost=self._number(COST, moment),
            solve_time=self._number(SOLVE_TIME, moment),
            latency=self._latency(moment),
            statuses=tuple(statuses.values()),
        )

    def _target(
        self, moment: Moment, figures: Mapping[str, float], flown: FlownOrbit | None
    ) -> TargetSight | None:
        """Where it was measured last, where the controller takes it to be, where it truly is."""
        places = ((name, self._heard(name, moment)) for name in (TARGET, TARGET_ODOMETRY))
        seen = [(self._topics[name].heard(at), name, at) for name, at in places if at is not None]
        measured: NDArray[np.float64] | None = None
        if seen:
            _, name, at = max(seen)
            measured = self._figures.of(name, at)
        truth: NDArray[np.float64] | None = self._figures.of(
            TARGET_TRUTH, self._stamped(TARGET_TRUTH, moment)
        )
        if all(name in figures for name in TRACKED):
            position = np.array([figures[name] for name in TRACKED])
            velocity = None if flown is None else flown.velocity  # the target carries it along
            std = figures.get("target_std", math.nan)
            return TargetSight(position, velocity, std, measured, truth)
        known = truth if measured is None else measured
        return None if known is None else TargetSight(known, measured=measured, truth=truth)

    def _mode(
        self, moment: Moment, figures: Mapping[str, float], values: Mapping[str, str]
    ) -> tuple[FallbackMode | None, str]:
        """What is flown, and why it is not optimal; None before the first command."""
        place = self._stamped(COMMAND, moment)
        if place is None:
            return None, ""
        said, why = reported_mode(values)
        late = self._time.age(self._topics[COMMAND], place, moment)
        if late > UNANSWERED:
            if said is FallbackMode.SILENCE:
                return said, why
            return FallbackMode.SILENCE, f"no command for {late / SECOND:.1f} s"
        # With each command comes its mode, but for those without a target.
        mode = told_mode(figures.get("mode", math.nan)) or said
        return mode, why if mode is said else ""

    def _latency(self, moment: Moment) -> float:
        """From the state that the newest command answers to that command, as both were heard."""
        command, odometry = self._stamped(COMMAND, moment), self._topics[ODOMETRY]
        if command is None:
            return math.nan
        commands = self._topics[COMMAND]
        state = odometry.newest_stamped(commands.stamp(command))
        if state is None or odometry.stamp(state) != commands.stamp(command):
            return math.nan
        return (commands.heard(command) - odometry.heard(state)) / SECOND

    def _heard(self, name: str, moment: Moment) -> Place | None:
        """The newest message of a topic, if there is one."""
        return self._topics[name].newest(moment.heard) if name in self._topics else None

    def _stamped(self, name: str, moment: Moment) -> Place | None:
        """The newest message of a topic by its stamp: the one that belongs to a state."""
        return self._time.beside(self._topics[name], moment) if name in self._topics else None

    def _beside(self, name: str, moment: Moment) -> Any:
        """What belongs to a state, unless it is too old to."""
        place = self._stamped(name, moment)
        if place is None or self._time.age(self._topics[name], place, moment) > UNANSWERED:
            return None
        return self._figures.of(name, place)

    def _number(self, name: str, moment: Moment) -> float:
        value = self._figures.of(name, self._heard(name, moment))
        return math.nan if value is None else float(value)


def _wind(
    figures: Mapping[str, float], motion: Measurement, airspeed: float | None
) -> NDArray[np.float64] | None:
    """As the controller estimates it, else that of the wind triangle, v_ground - v_air."""
    if all(name in figures for name in WIND):
        return np.array([figures[name] for name in WIND])
    if airspeed is None:
        return None
    through_air = air_velocity(motion.heading, motion.path_angle, airspeed, math)
    return motion.ground_velocity - np.array(through_air)
