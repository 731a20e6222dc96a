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

"""What the controller reports to whoever runs it."""

from __future__ import annotations

from collections import deque
from enum import Enum
from typing import NamedTuple

CAPACITY = 1000  # events kept until somebody takes them


class Level(Enum):
    """How serious it is."""

    INFO = "info"
    WARNING = "warning"
    MODE = "mode"  # another fallback mode is flown: may alternate from command to command
    REFUSAL = "refusal"  # of one measurement: may come as often as measurements do


class Event(NamedTuple):
    """Something to report.

    Attributes:
        level: How serious it is.
        words: For people.
    """

    level: Level
    words: str


class EventLog:
    """What has happened and nobody has taken yet; the oldest are dropped first."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=CAPACITY)

    def add(self, level: Level, words: str) -> None:
        """Report something.

        Args:
            level: How serious it is.
            words: For people.
        """
        self._events.append(Event(level, words))

    def take(self) -> list[Event]:
        """What has happened since the last call, oldest first."""
        events = []
        while self._events:  # one by one: another thread may add some meanwhile
            events.append(self._events.popleft())
        return events
