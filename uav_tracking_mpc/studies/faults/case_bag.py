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

"""The messages of one case: kept in memory, written as an MCAP bag if the case failed."""

from __future__ import annotations

from collections import deque
from pathlib import Path

from uav_tracking_mpc.nodes.flight_bag import FlightBag
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, Topic
from uav_tracking_mpc.studies.faults.streams import ORDERS, STREAMS, raw

MOST = 100_000  # messages; a case has a tenth of it
BEFORE = 1_000_000_000  # ns of what came before the case

# Of every relayed topic both sides: as sent (under ``raw``) and as received.
TOPICS = (*(raw(topic) for topic in STREAMS), *STREAMS, DIAGNOSTICS, ORDERS)


class CaseBag:
    """The latest messages of every topic."""

    def __init__(self) -> None:
        self._messages: deque[tuple[Topic, int, bytes]] = deque(maxlen=MOST)

    def add(self, topic: Topic, time: int, data: bytes) -> None:
        """Keep a message.

        Args:
            topic: On which it was heard.
            time: When it was heard [ns].
            data: The message, serialized.
        """
        self._messages.append((topic, time, data))

    def begin(self, time: int) -> None:
        """A case begins: forget what came more than a second before.

        Args:
            time: When it begins [ns].
        """
        while self._messages and self._messages[0][1] < time - BEFORE:
            self._messages.popleft()

    def write(self, path: Path) -> None:
        """Write what is kept as an MCAP file.

        Args:
            path: Of the file.
        """
        bag = FlightBag(path, TOPICS)
        for topic, time, data in self._messages:
            bag.write(topic, time, data)
        bag.close()
