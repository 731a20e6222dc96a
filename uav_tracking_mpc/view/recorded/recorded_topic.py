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

"""Messages of one topic of a bag, found by when they were heard or by their stamps."""

from __future__ import annotations

import struct
from bisect import bisect_right
from typing import NamedTuple

from uav_tracking_mpc.view.recorded.bag_chunks import BagChunks
from uav_tracking_mpc.view.recorded.bag_index import BagIndex

SECOND = 1_000_000_000  # ns
STAMP_AT = 4  # bytes: behind how the rest is encoded; a header's stamp is the first field
LITTLE_ENDIAN = 1  # in the second of them
LITTLE, BIG = struct.Struct("<iI"), struct.Struct(">iI")


class Place(NamedTuple):
    """Where a message lies.

    Attributes:
        chunk: Among those that hold the topic.
        turn: Among the topic's messages of the chunk.
    """

    chunk: int
    turn: int


class RecordedTopic:
    """Messages in the order in which they were heard.

    Args:
        name: Absolute.
        index: Of the bag.
        chunks: Of the bag.
    """

    def __init__(self, name: str, index: BagIndex, chunks: BagChunks) -> None:
        own = {number for number, channel in index.channels.items() if channel.topic == name}
        self._name, self._chunks = name, chunks
        self._numbers = [k for k, place in enumerate(index.chunks) if place.channels & own]
        self._starts = [index.chunks[k].start for k in self._numbers]
        self._first_stamps: dict[int, int] = {}

    def heard(self, place: Place) -> int:
        """When a message was heard in [ns].

        Args:
            place: Of the message.
        """
        return self._heard(place.chunk)[place.turn]

    def data(self, place: Place) -> bytes:
        """A message, serialized.

        Args:
            place: Of the message.
        """
        messages = self._chunks.messages(self._numbers[place.chunk])
        begin, end = messages.spans[self._name][place.turn]
        return messages.data[begin:end]

    def stamp(self, place: Place) -> int:
        """Stamp of a message that begins with a header, in [ns].

        Args:
            place: Of the message.
        """
        return self._stamps(place.chunk)[place.turn]

    def newest(self, time: int) -> Place | None:
        """The last message that had been heard at a time; None where there was none.

        Args:
            time: In [ns].
        """
        chunk = bisect_right(self._starts, time) - 1
        while chunk >= 0:
            index = bisect_right(self._heard(chunk), time) - 1
            if index >= 0:
                return Place(chunk, index)
            chunk -= 1
        return None

    def before(self, place: Place) -> Place | None:
        """The message before one; None where that is the first.

        Args:
            place: Of the one.
        """
        chunk, index = place
        while index == 0:
            chunk -= 1
            if chunk < 0:
                return None
            index = len(self._heard(chunk))
        return Place(chunk, index - 1)

    def newest_stamped(self, stamp: int) -> Place | None:
        """The last message with at most a stamp, where stamps rise; None where there is none.

        Args:
            stamp: In [ns].
        """
        count = len(self._numbers)
        chunk = bisect_right(range(count), stamp, key=self._first_stamp) - 1
        if chunk < 0:
            return None
        return Place(chunk, max(bisect_right(self._stamps(chunk), stamp) - 1, 0))

    @property
    def first(self) -> Place | None:
        """The first message; None where there is none."""
        for chunk in range(len(self._numbers)):
            if self._heard(chunk):
                return Place(chunk, 0)
        return None

    @property
    def last(self) -> Place | None:
        """The last message; None where there is none."""
        for chunk in reversed(range(len(self._numbers))):
            if heard := self._heard(chunk):
                return Place(chunk, len(heard) - 1)
        return None

    def sample(self, count: int) -> list[Place]:
        """Messages spread over the record, in order.

        Args:
            count: How many, at most.
        """
        step = max(len(self._numbers) // count, 1)
        chunks = range(0, len(self._numbers), step)
        return [Place(chunk, 0) for chunk in chunks if self._heard(chunk)]

    def _heard(self, chunk: int) -> list[int]:
        return self._chunks.messages(self._numbers[chunk]).heard.get(self._name, [])

    def _stamps(self, chunk: int) -> list[int]:
        messages = self._chunks.messages(self._numbers[chunk])
        if self._name not in messages.stamps:
            spans = messages.spans.get(self._name, [])
            messages.stamps[self._name] = [header_stamp(messages.data, begin) for begin, _ in spans]
        return messages.stamps[self._name]

    def _first_stamp(self, chunk: int) -> int:
        """That of the first message; of the chunk before where a damaged one holds none."""
        if chunk not in self._first_stamps:
            stamps = self._stamps(chunk)
            before = self._first_stamp(chunk - 1) if chunk and not stamps else 0
            self._first_stamps[chunk] = stamps[0] if stamps else before
        return self._first_stamps[chunk]


def header_stamp(data: bytes, begin: int) -> int:
    """Stamp of a serialized message that begins with a header, in [ns].

    Args:
        data: In CDR.
        begin: First byte of the message.
    """
    little = data[begin + 1] & LITTLE_ENDIAN
    seconds, rest = (LITTLE if little else BIG).unpack_from(data, begin + STAMP_AT)
    return int(seconds * SECOND + rest)
