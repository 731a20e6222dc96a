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

"""Flights of a bag, whoever recorded it: all its aircraft, found by their topics. Needs no ROS."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.record import recorded_parameters
from uav_tracking_mpc.nodes.messages.heard_values import VALUES
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
    Topic,
)
from uav_tracking_mpc.report.bag import BagError, name_of
from uav_tracking_mpc.report.bag_index import SECOND, Bag, BagTopic, Place
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.snapshot import flown_mode, heard_sight, number
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SILENT,
    FlightSource,
    KeptFlight,
    NodeStatus,
    PlayClock,
    Sight,
)

logger = logging.getLogger(__name__)

RECORD = "controller.jsonl"  # as `fly` calls it
NAMED = 8  # topics that a message names
SAMPLES = 16  # states whose stamps are compared
KEPT = 4000  # messages that are not read again
UNANSWERED = 1.0  # s of flight after which what a controller sent counts no longer
GONE = 5 * SECOND  # ns after which a node that reports once a second is silent
FORGOTTEN = 60 * SECOND  # ns after which a silent one is not shown


class Moment(NamedTuple):
    """When a state was.

    Attributes:
        heard: By the recorder's clock in [ns].
        flown: By the flight's in [ns].
    """

    heard: int
    flown: int


class RecordedTime:
    """Time of one record, the same for all of its aircraft: that of the stamps of its states.

    It counts from the first command on. A simulator's time may run faster than the recorder's, and
    stand. Where stamps do not rise over the record, because a simulator was started anew or nobody
    stamps, it is the recorder's time.

    Args:
        states: Odometry of each aircraft, at least one message in all.
        commands: Commands of each aircraft.

    Attributes:
        clock: From the first to the last state; it begins at the first command.
        stamped: Whether it is the time of stamps.
    """

    def __init__(self, states: Sequence[BagTopic], commands: Sequence[BagTopic]) -> None:
        self.stamped = all(_rising(topic) for topic in states)
        firsts = [topic.time(topic.first, self.stamped) for topic in states if topic.first]
        lasts = [topic.time(topic.last, self.stamped) for topic in states if topic.last]
        sent = [topic.time(topic.first, self.stamped) for topic in commands if topic.first]
        first, last = min(firsts), max(lasts)
        self._zero = min((time for time in sent if first <= time <= last), default=first)
        self.clock = PlayClock((first - self._zero) / SECOND, (last - self._zero) / SECOND)
        self.clock.seek(0.0)  # before the first command an aircraft may have waited for minutes

    def moment(self, states: BagTopic, place: Place) -> Moment:
        """When a state was.

        Args:
            states: Odometry of the aircraft.
            place: Of the state.
        """
        return Moment(states.time(place), states.time(place, self.stamped))

    def seconds(self, moment: Moment) -> float:
        """Time of the record in [s].

        Args:
            moment: Of a state.
        """
        return (moment.flown - self._zero) / SECOND

    def newest(self, states: BagTopic, time: float) -> Place | None:
        """The last state at a time; None before the first one.

        Args:
            states: Odometry of the aircraft.
            time: In [s].
        """
        # A nanosecond is lost where seconds are floats: the state of that very time counts.
        return states.newest(self._zero + math.floor(time * SECOND + 0.5), self.stamped)


def _rising(states: BagTopic) -> bool:
    """Whether later states have later stamps, as far as some of them tell."""
    places = [*states.sample(SAMPLES), *filter(None, [states.last])]
    stamps = [states.time(place, stamped=True) for place in dict.fromkeys(places)]
    return all(before < after for before, after in pairwise(stamps))


class RecordedFlight(KeptFlight):
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
        topics: Mapping[str, BagTopic],
        time: RecordedTime,
        tracking: TrackingParameters | None,
    ) -> None:
        super().__init__(namespace.replace("/", "_") or "uav", time.clock, tracking)
        self._namespace, self._topics, self._time = namespace, topics, time
        self._read = lru_cache(KEPT)(self._decoded)

    def at(self, time: float, whole: bool = True) -> Sight | None:
        """What there was to see at a time; None before the first state.

        Args:
            time: In [s] of the record.
            whole: With plan and statuses, which take long to read.
        """
        states = self._topics[ODOMETRY.name]
        place = self._time.newest(states, time)
        while place is not None and self._read(ODOMETRY.name, place) is None:  # that was no state
            place = states.before(place)
        if place is None:
            return None
        moment = self._time.moment(states, place)
        figures: Mapping[str, float] = self._beside(TRACKING_ERRORS, moment) or {}
        reports = self._reports(moment.heard, whole)
        controller, age = reports.get(CONTROLLER, (None, 0))
        values = {} if controller is None or age > GONE else controller.values
        command, silence, latency = self._stamped(COMMAND, moment), math.inf, math.nan
        if command is not None:
            silence, latency = self._age(COMMAND, command, moment), self._latency(command)
        truth = self._stamped(TARGET_TRUTH, moment)
        mode, reason = flown_mode(silence, UNANSWERED, figures, values)
        return heard_sight(
            self._time.seconds(moment),
            self._read(ODOMETRY.name, place),
            self._beside(AIR_VELOCITY, moment),
            figures,
            self._beside(ORBIT, moment),
            (self._measured(moment), self._value(TARGET_TRUTH, truth)),
            values,
            plan=self._beside(COMMAND, moment) if whole else None,
            mode=mode,
            reason=reason,
            cost=number(self._heard(TRACKING["cost"], moment)),
            solve_time=number(self._heard(TRACKING["solve_time"], moment)),
            latency=latency,
            statuses=tuple(
                replace(status, level=SILENT) if age > GONE else status
                for _, (status, age) in sorted(reports.items())
                if whole
            ),
        )

    def _reports(self, time: int, whole: bool) -> dict[str, tuple[NodeStatus, int]]:
        """The newest report of each node and its age in [ns]; without the whole, the controller's.

        Args:
            time: In [ns] by the recorder's clock.
            whole: Also those of nodes that have fallen silent.
        """
        found: dict[str, tuple[NodeStatus, int]] = {}
        topic = self._topics.get(DIAGNOSTICS.name)
        place = None if topic is None else topic.newest(time)
        while topic is not None and place is not None and (whole or CONTROLLER not in found):
            age = time - topic.time(place)
            if age > (FORGOTTEN if whole else GONE):
                break
            for namespace, *status, _ in self._value(DIAGNOSTICS, place) or ():
                if namespace == self._namespace:
                    found.setdefault(status[0], (NodeStatus(*status), age))
            place = topic.before(place)
        return found

    def _measured(self, moment: Moment) -> NDArray[np.float64] | None:
        """Where the target was measured last."""
        own = ((topic, self._topics.get(topic.name)) for topic in (TARGET, TARGET_ODOMETRY))
        heard = [
            (messages.time(place), topic.name, place)
            for topic, messages in own
            if messages is not None and (place := messages.newest(moment.heard)) is not None
        ]
        if not heard:
            return None
        _, name, place = max(heard)
        found: NDArray[np.float64] | None = self._read(name, place)
        return found

    def _latency(self, command: Place) -> float:
        """From the state that a command answers to that command, as both were heard, in [s]."""
        commands, states = self._topics[COMMAND.name], self._topics[ODOMETRY.name]
        stamp = commands.time(command, stamped=True)
        state = states.newest(stamp, stamped=True)
        if state is None or states.time(state, stamped=True) != stamp:
            return math.nan
        return (commands.time(command) - states.time(state)) / SECOND

    def _stamped(self, topic: Topic, moment: Moment) -> Place | None:
        """The newest message of a topic by its stamp: the one that belongs to a state."""
        found, stamped = self._topics.get(topic.name), self._time.stamped
        if found is None:
            return None
        return found.newest(moment.flown if stamped else moment.heard, stamped)

    def _age(self, topic: Topic, place: Place, moment: Moment) -> float:
        """How long before a state a message of another topic was, in [s]."""
        time = self._topics[topic.name].time(place, self._time.stamped)
        return (moment.flown - time) / SECOND

    def _beside(self, topic: Topic, moment: Moment) -> Any:
        """What belongs to a state, unless it is too old to."""
        place = self._stamped(topic, moment)
        if place is None or self._age(topic, place, moment) > UNANSWERED:
            return None
        return self._value(topic, place)

    def _heard(self, topic: Topic, moment: Moment) -> Any:
        """What was heard last on a topic."""
        found = self._topics.get(topic.name)
        return None if found is None else self._value(topic, found.newest(moment.heard))

    def _value(self, topic: Topic, place: Place | None) -> Any:
        """What a message says; None where there is none or it cannot be used."""
        return None if place is None else self._read(topic.name, place)

    def _decoded(self, name: str, place: Place) -> Any:
        try:
            return READ[name](self._topics[name].message(place))
        except Exception:  # bytes that are no such message, or numbers that are none
            return None


class RecordedSource(FlightSource):
    """Aircraft of a bag.

    Args:
        path: Of the bag, an MCAP file or the folder of a recorder.
        tracking: What the controllers flew by; None takes what the controller of a single aircraft
            recorded beside the bag, if it did.

    Raises:
        BagError: It is no bag, is cut off or damaged, or holds no aircraft.
        OSError: It cannot be read.
    """

    clock: PlayClock

    def __init__(self, path: Path, tracking: TrackingParameters | None = None) -> None:
        self._bag = Bag(path, KINDS)
        aircraft: dict[str, dict[str, BagTopic]] = {}
        shared: dict[str, BagTopic] = {}
        for topic, kind in self._bag.kinds.items():
            name = name_of(topic, KINDS)
            if name is not None and kind == KINDS[name]:
                namespace = f"/{topic.lstrip('/')}"[: -len(name)].strip("/")
                owner = shared if topic == name else aircraft.setdefault(namespace, {})
                owner[name] = BagTopic(self._bag, topic)
        flown = {
            namespace: {**own, **shared}
            for namespace, own in sorted(aircraft.items())
            if ODOMETRY.name in own and own[ODOMETRY.name].first is not None
        }
        if not flown:
            self.close()
            raise BagError(_nothing(self._bag))
        if tracking is None and len(flown) == 1:
            tracking = _recorded_beside(path)
        time = RecordedTime(
            [own[ODOMETRY.name] for own in flown.values()],
            [own[COMMAND.name] for own in flown.values() if COMMAND.name in own],
        )
        self.clock = time.clock
        self._flights = [
            RecordedFlight(namespace, own, time, tracking) for namespace, own in flown.items()
        ]

    def flights(self) -> Sequence[RecordedFlight]:
        """All of them."""
        return self._flights

    def close(self) -> None:
        """Close the bag."""
        self._bag.close()


def _recorded_beside(path: Path) -> TrackingParameters | None:
    """What the controller recorded beside the bag; None where it did not, or unreadably."""
    record = path / RECORD if path.is_dir() else path.with_name(RECORD)
    if not record.is_file():
        return None
    try:
        return recorded_parameters(record)
    except Exception as error:  # whatever is in that file, the bag is shown
        logger.warning("the limits are not shown: %s cannot be read: %s", record, error)
        return None


def _nothing(bag: Bag) -> str:
    """That there is no aircraft, and what there is instead."""
    if not bag.chunks:
        return f"bag {bag.path} holds no message"
    topics = sorted(bag.kinds)
    held = ", ".join(topics[:NAMED]) + (", ..." if len(topics) > NAMED else "")
    return (
        f"bag {bag.path} holds no aircraft: no message on a topic {ODOMETRY.name} of type "
        f"{ODOMETRY.type_name}; its topics are {held or 'none of ROS 2'}"
    )


def _plan(message: Any) -> NDArray[np.float64] | None:
    """Planned positions, shape (n, 3), in [m]; None where the command holds none."""
    places = [point.transforms[0].translation for point in message.points if point.transforms]
    positions = np.array([(place.x, place.y, place.z) for place in places])
    return positions if len(positions) and np.isfinite(positions).all() else None


READ = {**VALUES, COMMAND.name: _plan}
KINDS = {topic.name: topic.type_name for topic in ALL if topic.name in READ}
