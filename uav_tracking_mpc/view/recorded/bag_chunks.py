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

"""Chunks of a bag, unpacked when they are looked at; the last ones stay in memory."""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field

from uav_tracking_mpc.view.recorded.bag_index import (
    BROKEN,
    IDENTITIES,
    MESSAGE,
    MESSAGE_HEAD,
    RECORD,
    BagIndex,
    unpacked,
)

logger = logging.getLogger(__name__)

KEPT = 48 * 2**20  # bytes of unpacked chunks


@dataclass(frozen=True)
class ChunkMessages:
    """Messages of one chunk, by topic.

    Attributes:
        data: Unpacked.
        heard: When each message of a topic was heard in [ns], in order.
        spans: First byte of each, and the byte behind it.
        stamps: Of topics that begin with a header, in [ns]; kept by who reads them.
    """

    data: bytes
    heard: dict[str, list[int]] = field(default_factory=dict)
    spans: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    stamps: dict[str, list[int]] = field(default_factory=dict)


class BagChunks:
    """Reads chunks.

    Args:
        index: Of the bag.
        topics: Name of the topic of each channel that is wanted.

    Raises:
        OSError: The file cannot be read.
    """

    def __init__(self, index: BagIndex, topics: Mapping[int, str]) -> None:
        self._index = index
        self._topics: list[dict[int, str]] = [{} for _ in index.files]
        for number, topic in topics.items():
            file, channel = divmod(number, IDENTITIES)
            self._topics[file][channel] = topic
        self._files = [path.open("rb") for path in index.files]
        self._read: OrderedDict[int, ChunkMessages] = OrderedDict()
        self._size = 0

    def messages(self, number: int) -> ChunkMessages:
        """Messages of a chunk; none where it is damaged, which is logged.

        Args:
            number: Of the chunk in the index.
        """
        if number in self._read:
            self._read.move_to_end(number)
            return self._read[number]
        found = self._read[number] = self._load(number)
        self._size += len(found.data)
        while self._size > KEPT and len(self._read) > 1:
            _, oldest = self._read.popitem(last=False)
            self._size -= len(oldest.data)
        return found

    def _load(self, number: int) -> ChunkMessages:
        place = self._index.chunks[number]
        self._files[place.file].seek(place.offset)
        content = self._files[place.file].read(place.size)
        try:
            data = unpacked(content) if place.packed else content
            return _sorted_out(data, self._topics[place.file])
        except BROKEN as error:
            path = self._index.files[place.file]
            logger.warning("bag %s is damaged at byte %d: %s", path, place.offset, error)
            return ChunkMessages(b"")

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()
        self._read.clear()


def _sorted_out(data: bytes, topics: Mapping[int, str]) -> ChunkMessages:
    """Where the messages of each topic lie; one loop, for there are thousands in a chunk."""
    found = ChunkMessages(data)
    heard, spans = found.heard, found.spans
    at, last = 0, len(data) - RECORD.size
    while at <= last:
        code, size = RECORD.unpack_from(data, at)
        begin = at + RECORD.size
        at = begin + size
        if code != MESSAGE:
            continue
        channel, _, time, _ = MESSAGE_HEAD.unpack_from(data, begin)
        topic = topics.get(channel)
        if topic is None:
            continue
        if topic not in heard:
            heard[topic], spans[topic] = [], []
        heard[topic].append(time)
        spans[topic].append((begin + MESSAGE_HEAD.size, at))
    for topic, times in heard.items():
        if times != sorted(times):  # of several senders
            order = sorted(range(len(times)), key=times.__getitem__)
            heard[topic] = [times[k] for k in order]
            spans[topic] = [spans[topic][k] for k in order]
    return found
