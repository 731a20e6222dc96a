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
"""Messages of a bag by topic and time, however long the bag is; needs the package mcap.

MCAP states at the end of a file where the messages of each topic lie: a bag of two hours opens as
fast as one of a minute, and chunks are unpacked when they are looked at. A file that does not state
it is first copied to a temporary one that does.
"""

from __future__ import annotations

import logging
import os
import struct
import tempfile
from bisect import bisect_right
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from io import BytesIO
from operator import attrgetter
from pathlib import Path
from typing import IO, Any, NamedTuple

from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Chunk, ChunkIndex
from mcap.records import Message as MessageRecord
from mcap.stream_reader import ReadDataStream, breakup_chunk
from mcap.summary import Summary
from mcap.writer import CompressionType, Writer

from uav_tracking_mpc.report.bag import BagError, decoded, name_of, typestore

logger = logging.getLogger(__name__)

SECOND = 1_000_000_000  # ns
KEPT = 48 * 2**20  # bytes of unpacked chunks
MAGIC = b"\x89MCAP0\r\n"  # first and last bytes of the file
RECORD_HEAD = 9  # bytes in front of every record: what it is, its size
FOOTER_SIZE = RECORD_HEAD + 20 + len(MAGIC)  # bytes from the last record to the end
METADATA = "metadata.yaml"  # as ROS 2 calls it
ENCODING = "cdr"  # of ROS 2
STAMP_AT = 4  # bytes: behind how the rest is encoded; a header's stamp is the first field
LITTLE, BIG = struct.Struct("<iI"), struct.Struct(">iI")
# What a reader says of bytes that are no such record: zstandard and lz4 have errors of their own.
BROKEN = Exception


class Place(NamedTuple):
    """Where a message lies.

    Attributes:
        chunk: Among those that hold the topic.
        turn: Among the topic's messages of the chunk.
    """

    chunk: int
    turn: int


@dataclass(frozen=True)
class _Chunk:
    """A chunk of a file, and the topics that are read of it, by the numbers of their channels."""

    file: IO[bytes]
    index: ChunkIndex
    channels: Mapping[int, str]

    @property
    def topics(self) -> set[str]:
        """That it holds messages of."""
        return set(self.channels.values())


@dataclass(frozen=True)
class _Messages:
    """Messages of one topic in one chunk, in the order in which they were heard."""

    heard: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)  # as soon as they are asked for


class Bag:
    """A bag that is read where it is looked at.

    Args:
        path: Of an MCAP file, or of the folder of a recorder, whose files are one bag where it has
            a ``metadata.yaml``; without that it must hold one.
        names: Of the topics that are read, as :func:`~uav_tracking_mpc.report.bag.name_of` takes
            them; all by default.

    Attributes:
        path: As above.
        kinds: Type of each topic of ROS 2, such as ``nav_msgs/msg/Odometry``, by absolute name.

    Raises:
        BagError: It is no such file or folder, is cut off or damaged.
        OSError: It cannot be read.
    """

    def __init__(self, path: Path, names: Collection[str] | None = None) -> None:
        self.path, self.kinds, self._names = path, dict[str, str](), names
        self._files: list[IO[bytes]] = []
        typestore()  # not when the first message is read
        chunks = [chunk for part in _parts(path) for chunk in self._chunks_of(part)]
        self.chunks = sorted(chunks, key=lambda chunk: chunk.index.message_start_time)
        largest = max((chunk.index.uncompressed_size for chunk in chunks), default=KEPT)
        self.unpacked = lru_cache(max(KEPT // max(largest, 1), 1))(self._unpack)

    def _chunks_of(self, part: Path) -> Iterator[_Chunk]:
        file, summary = _opened(part)
        self._files.append(file)
        ours = {
            k: each for k, each in summary.channels.items() if each.message_encoding == ENCODING
        }
        for channel in ours.values():
            self.kinds[channel.topic] = summary.schemas[channel.schema_id].name
        read = {
            k: each.topic
            for k, each in ours.items()
            if self._names is None or name_of(each.topic, self._names) is not None
        }
        for index in summary.chunk_indexes:
            held = {k: read[k] for k in index.message_index_offsets if k in read}
            yield _Chunk(file, index, held)

    def _unpack(self, number: int) -> dict[str, _Messages]:
        """Messages of a chunk by topic; none where it is damaged, which is logged."""
        chunk, found = self.chunks[number], dict[str, _Messages]()
        begin, size = chunk.index.chunk_start_offset, chunk.index.chunk_length
        try:
            chunk.file.seek(begin + RECORD_HEAD)
            content = BytesIO(chunk.file.read(size - RECORD_HEAD))
            records = breakup_chunk(Chunk.read(ReadDataStream(content)), validate_crc=True)
        except BROKEN as error:
            logger.warning("bag %s is damaged at byte %d: %s", self.path, begin, error)
            return found
        held = (each for each in records if isinstance(each, MessageRecord))
        for message in sorted(held, key=attrgetter("log_time")):
            if message.channel_id in chunk.channels:
                messages = found.setdefault(chunk.channels[message.channel_id], _Messages())
                messages.heard.append(message.log_time)
                messages.data.append(message.data)
        return found

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()
        self.unpacked.cache_clear()


class BagTopic:
    """Messages of one topic, found by when they were heard or by their stamps.

    Args:
        bag: That holds them.
        name: Absolute.

    Attributes:
        kind: Type as ROS writes it.
    """

    def __init__(self, bag: Bag, name: str) -> None:
        self._bag, self._name, self.kind = bag, name, bag.kinds[name]
        self._numbers = [k for k, chunk in enumerate(bag.chunks) if name in chunk.topics]
        self._starts = [bag.chunks[k].index.message_start_time for k in self._numbers]
        self._first_stamps: dict[int, int] = {}

    def message(self, place: Place) -> Any:
        """A message, with the names of its fields in ROS.

        Args:
            place: Of the message.

        Raises:
            ValueError: It is no message of this type.
        """
        return decoded(self._of(place.chunk).data[place.turn], self.kind)

    def time(self, place: Place, stamped: bool = False) -> int:
        """When a message was heard, or its stamp, in [ns].

        Args:
            place: Of the message.
            stamped: Whether its stamp is asked for; it begins with a header then.
        """
        return self._times(place.chunk, stamped)[place.turn]

    def newest(self, time: int, stamped: bool = False) -> Place | None:
        """The last message at a time; None where there was none.

        Args:
            time: In [ns].
            stamped: Whether stamps count, which must rise, or when messages were heard.
        """
        key = self._first_stamp if stamped else self._starts.__getitem__
        chunk = bisect_right(range(len(self._numbers)), time, key=key) - 1
        while chunk >= 0:
            turn = bisect_right(self._times(chunk, stamped), time) - 1
            if turn >= 0:
                return Place(chunk, turn)
            chunk -= 1
        return None

    def before(self, place: Place) -> Place | None:
        """The message before one; None where that is the first.

        Args:
            place: Of the one.
        """
        chunk, turn = place
        while turn == 0:
            chunk -= 1
            if chunk < 0:
                return None
            turn = len(self._of(chunk).heard)
        return Place(chunk, turn - 1)

    @property
    def first(self) -> Place | None:
        """The first message; None where there is none."""
        return next(self._begins(1), None)

    @property
    def last(self) -> Place | None:
        """The last message; None where there is none."""
        return self.newest(2**64)

    def sample(self, count: int) -> list[Place]:
        """Messages spread over the record, in order.

        Args:
            count: How many, at most.
        """
        return list(self._begins(max(len(self._numbers) // count, 1)))

    def _begins(self, step: int) -> Iterator[Place]:
        """The first message of each chunk, of every second one, and so on."""
        for chunk in range(0, len(self._numbers), step):
            if self._of(chunk).heard:
                yield Place(chunk, 0)

    def _of(self, chunk: int) -> _Messages:
        return self._bag.unpacked(self._numbers[chunk]).get(self._name, _Messages())

    def _times(self, chunk: int, stamped: bool) -> list[int]:
        messages = self._of(chunk)
        if not stamped:
            return messages.heard
        if not messages.stamps:
            messages.stamps.extend(map(header_stamp, messages.data))
        return messages.stamps

    def _first_stamp(self, chunk: int) -> int:
        """That of the first message; of the chunk before where a damaged one holds none."""
        if chunk not in self._first_stamps:
            stamps = self._times(chunk, stamped=True)
            before = self._first_stamp(chunk - 1) if chunk and not stamps else 0
            self._first_stamps[chunk] = stamps[0] if stamps else before
        return self._first_stamps[chunk]


def header_stamp(data: bytes | memoryview) -> int:
    """Stamp of a serialized message that begins with a header, in [ns].

    Args:
        data: In CDR, whose second byte tells the order of bytes.
    """
    if len(data) < STAMP_AT + LITTLE.size:
        return 0  # it was torn off: decoding will say so
    seconds, rest = (LITTLE if data[1] & 1 else BIG).unpack_from(data, STAMP_AT)
    return int(seconds * SECOND + rest)


def _parts(path: Path) -> list[Path]:
    """Files of a bag."""
    if not path.exists():
        raise BagError(f"there is no bag {path}")
    if not path.is_dir():
        return [path]
    files = sorted(path.glob("*.mcap"))
    if len(files) > 1 and not (path / METADATA).is_file():
        raise BagError(f"folder {path} has no {METADATA} and {len(files)} bags: name one of them")
    if not files:
        raise BagError(f"folder {path} holds no bag: no file ends in .mcap")
    return files


def _opened(part: Path) -> tuple[IO[bytes], Summary]:
    """A file, and what it states of all its messages; a copy where it does not."""
    try:
        file = part.open("rb")
        _check(part, file)
        summary = _summary(file)
        if summary is not None and _leads_everywhere(summary):
            return file, summary
        with file:
            file.seek(0)
            return _copy(file)
    except (BagError, OSError):
        raise
    except BROKEN as error:
        raise BagError(f"bag {part} is damaged: its index cannot be read: {error}") from error


def _summary(file: IO[bytes]) -> Summary | None:
    file.seek(0)
    return make_reader(file).get_summary()


def _check(path: Path, file: IO[bytes]) -> None:
    """Refuse what is no MCAP file from its first to its last byte."""
    size = os.fstat(file.fileno()).st_size
    if size == 0:
        raise BagError(f"bag {path} is empty: 0 bytes")
    if file.read(len(MAGIC)) != MAGIC:
        raise BagError(f"{path} is no bag: it does not begin as an MCAP file does")
    file.seek(-min(FOOTER_SIZE, size), os.SEEK_END)
    if size < FOOTER_SIZE + len(MAGIC) or not file.read().endswith(MAGIC):
        raise BagError(
            f"bag {path} is cut off: its end with the index is missing, as where a recorder was "
            "killed; `mcap recover` saves what it holds"
        )


def _leads_everywhere(summary: Summary) -> bool:
    """Whether each chunk states its messages, and their topics and types are stated, too."""
    stated = [chunk.message_index_offsets.keys() for chunk in summary.chunk_indexes]
    described = all(each.schema_id in summary.schemas for each in summary.channels.values())
    return bool(stated) and described and all(s and s <= summary.channels.keys() for s in stated)


def _copy(file: IO[bytes]) -> tuple[IO[bytes], Summary]:
    """The messages in a temporary file that states where each of them lies."""
    copy = tempfile.TemporaryFile()  # noqa: SIM115, closed with its bag
    writer = Writer(copy, compression=CompressionType.NONE)
    writer.start()
    channels: dict[tuple[str, str], int] = {}
    for schema, channel, message in NonSeekingReader(file).iter_messages(log_time_order=False):
        key = channel.topic, "" if schema is None else schema.name
        if key not in channels:
            kind = writer.register_schema(key[1], "", b"")
            channels[key] = writer.register_channel(key[0], channel.message_encoding, kind)
        writer.add_message(channels[key], message.log_time, message.data, message.log_time)
    writer.finish()
    summary = _summary(copy)
    assert summary is not None, "its writer states it"
    return copy, summary
