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

"""Time of a recorded flight: that of its stamps, from the first command on.

A simulator's time may run faster than the recorder's, and stand. Where stamps do not rise over the
record, because a simulator was started anew or nobody stamps, it is the recorder's time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from uav_tracking_mpc.view.play_clock import PlayClock
from uav_tracking_mpc.view.recorded.recorded_topic import SECOND, Place, RecordedTopic

SAMPLES = 16  # states whose stamps are compared


class Moment(NamedTuple):
    """When a state was.

    Attributes:
        heard: By the recorder's clock in [ns].
        flown: By the flight's in [ns].
    """

    heard: int
    flown: int


class RecordedTime:
    """Time of one record, the same for all of its aircraft.

    Args:
        states: Odometry of each aircraft, at least one message in all.
        commands: Commands of each aircraft.

    Attributes:
        clock: From the first to the last state; it begins at the first command.
    """

    def __init__(self, states: Sequence[RecordedTopic], commands: Sequence[RecordedTopic]) -> None:
        self._stamped = all(_rising(topic) for topic in states)
        firsts = [self._of(topic, topic.first) for topic in states]
        lasts = [self._of(topic, topic.last) for topic in states]
        sent = [self._of(topic, topic.first) for topic in commands]
        first = min(time for time in firsts if time is not None)
        last = max(time for time in lasts if time is not None)
        begun = [time for time in sent if time is not None and first <= time <= last]
        self._zero = min(begun, default=first)
        self.clock = PlayClock((first - self._zero) / SECOND, (last - self._zero) / SECOND)
        self.clock.seek(0.0)  # before the first command an aircraft may have waited for minutes

    def moment(self, states: RecordedTopic, place: Place) -> Moment:
        """When a state was.

        Args:
            states: Odometry of the aircraft.
            place: Of the state.
        """
        heard = states.heard(place)
        return Moment(heard, states.stamp(place) if self._stamped else heard)

    def seconds(self, moment: Moment) -> float:
        """Time of the record in [s].

        Args:
            moment: Of a state.
        """
        return (moment.flown - self._zero) / SECOND

    def newest(self, states: RecordedTopic, time: float) -> Place | None:
        """The last state at a time; None before the first one.

        Args:
            states: Odometry of the aircraft.
            time: In [s].
        """
        # A nanosecond is lost where seconds are floats: the state of that very time counts.
        wanted = self._zero + math.floor(time * SECOND + 0.5)
        return states.newest_stamped(wanted) if self._stamped else states.newest(wanted)

    def beside(self, topic: RecordedTopic, moment: Moment) -> Place | None:
        """The last message of another topic that is not stamped later than a state; None for none.

        Args:
            topic: Whose messages begin with a header.
            moment: Of the state.
        """
        if self._stamped:
            return topic.newest_stamped(moment.flown)
        return topic.newest(moment.heard)

    def age(self, topic: RecordedTopic, place: Place, moment: Moment) -> int:
        """How long before a state a message of another topic was, in [ns].

        Args:
            topic: Whose messages begin with a header.
            place: Of the message.
            moment: Of the state.
        """
        return moment.flown - (topic.stamp(place) if self._stamped else topic.heard(place))

    def _of(self, topic: RecordedTopic, place: Place | None) -> int | None:
        if place is None:
            return None
        return topic.stamp(place) if self._stamped else topic.heard(place)


def _rising(states: RecordedTopic) -> bool:
    """Whether later states have later stamps, as far as some of them tell."""
    places = [*states.sample(SAMPLES), *filter(None, [states.last])]
    stamps = [states.stamp(place) for place in dict.fromkeys(places)]
    return all(before < after for before, after in pairwise(stamps))
