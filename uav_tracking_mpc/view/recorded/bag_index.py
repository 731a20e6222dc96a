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

"""Where the messages of a bag lie: which topics each chunk holds, and from when to when.

MCAP states it at the end of the file, so that a bag of two hours opens as fast as one of a minute.
A bag whose messages stand outside of chunks, or that states nothing, is walked through once.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple

from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import ReadDataStream, get_chunk_data_stream
from mcap.summary import Summary

from uav_tracking_mpc.parameters.specification import ParameterError

MAGIC = b"\x89MCAP0\r\n"  # first and last bytes of the file
RECORD = struct.Struct("<BQ")  # in front of every record: what it is, its size in bytes
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, number, times [ns] heard and sent
FOOTER_SIZE = RECORD.size + 20 + len(MAGIC)  # bytes from the last record to the end
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x03, 0x04, 0x05, 0x06, 0x0F
RUN = 2**20  # bytes of messages outside of chunks that count as one
IDENTITIES = 2**16  # of channels in a file
METADATA = "metadata.yaml"  # as ROS 2 calls it
ENCODING = "cdr"  # of ROS 2
# What a reader says of bytes that are no such record: zstandard and lz4 have errors of their own.
BROKEN = Exception


class BagError(ParameterError):
    """A file cannot be shown as a flight; the text names it and says why."""


class RecordedChannel(NamedTuple):
    """Messages of one topic and type.

    Attributes:
        topic: Its absolute name.
        kind: Type as ROS writes it, such as ``nav_msgs/msg/Odometry``.
    """

    topic: str
    kind: str


class ChunkPlace(NamedTuple):
    """Messages that lie together.

    Attributes:
        start: When the first one was heard in [ns].
        end: When the last one was heard in [ns].
        offset: Of the first byte in the file.
        size: In bytes.
        packed: Whether it is a chunk record, compressed or not, or else plain messages.
        channels: Identities of those that have messages in it.
        file: Number of its file in the bag.
    """

    start: int
    end: int
    offset: int
    size: int
    packed: bool
    channels: frozenset[int]
    file: int = 0


@dataclass(frozen=True)
class BagIndex:
    """What a bag holds, and where.

    Attributes:
        path: Of the bag, a file or a folder.
        files: Of the bag, in order.
        channels: By identity, those of ROS 2 alone. Those of a file begin at IDENTITIES times its
            number.
        chunks: In the order of their times.
    """

    path: Path
    files: Sequence[Path]
    channels: Mapping[int, RecordedChannel]
    chunks: Sequence[ChunkPlace]


def read_bag(path: Path) -> BagIndex:
    """Read what a bag states of itself, whether it is a file or the folder of a recorder.

    Args:
        path: Of the MCAP file, or of the folder, whose MCAP files are one bag where it has a
            ``metadata.yaml``; without that it must hold one.

    Raises:
        BagError: It is no such file or folder, is cut off, damaged, or holds no message.
        OSError: It cannot be read.
    """
    if not path.exists():
        raise FileNotFoundError(f"there is no bag {path}")
    if not path.is_dir():
        return read_index(path)
    files = sorted(path.glob("*.mcap"))
    if len(files) > 1 and not (path / METADATA).is_file():
        raise BagError(f"folder {path} has no {METADATA} and {len(files)} bags: name one of them")
    if not files:
        raise BagError(f"folder {path} holds no bag: no file ends in .mcap")
    parts = [read_index(file) for file in files]
    return BagIndex(
        path,
        files,
        {
            IDENTITIES * file + number: channel
            for file, part in enumerate(parts)
            for number, channel in part.channels.items()
        },
        sorted(
            chunk._replace(
                file=file, channels=frozenset(IDENTITIES * file + k for k in chunk.channels)
            )
            for file, part in enumerate(parts)
            for chunk in part.chunks
        ),
    )


def read_index(path: Path) -> BagIndex:
    """Read what a file states of itself.

    Args:
        path: Of the MCAP file.

    Raises:
        BagError: It is no such file, is cut off, damaged, or holds no message.
        OSError: It cannot be read.
    """
    with path.open("rb") as file:
        _check(path, file)
        try:
            file.seek(0)
            found = _stated(make_reader(file).get_summary()) or _walked(file)
        except BROKEN as error:
            raise BagError(f"bag {path} is damaged: its index cannot be read: {error}") from error
    channels, chunks = found
    if not chunks:
        raise BagError(f"bag {path} holds no message")
    return BagIndex(path, [path], channels, sorted(chunks))


def records(data: bytes | mmap.mmap, begin: int = 0) -> Iterator[tuple[int, int, int]]:
    """Records that follow one another.

    Args:
        data: In which they lie.
        begin: Of the first one in bytes.

    Yields:
        What it is, first byte of its content and the byte behind it.
    """
    while begin + RECORD.size <= len(data):
        code, size = RECORD.unpack_from(data, begin)
        content = begin + RECORD.size
        begin = content + size
        yield code, content, begin


def unpacked(record: bytes) -> bytes:
    """Records of a chunk.

    Args:
        record: Content of the chunk record.
    """
    stream, size = get_chunk_data_stream(Chunk.read(_stream(record)), validate_crc=True)
    return stream.read(size)


def _check(path: Path, file: IO[bytes]) -> None:
    """Refuse what is no MCAP file from its first to its last byte."""
    size = os.fstat(file.fileno()).st_size
    if size == 0:
        raise BagError(f"bag {path} is empty: 0 bytes")
    if file.read(len(MAGIC)) != MAGIC:
        raise BagError(f"{path} is no bag: an MCAP file begins with {MAGIC!r}")
    file.seek(-min(FOOTER_SIZE, size), os.SEEK_END)
    if size < FOOTER_SIZE + len(MAGIC) or not file.read().endswith(MAGIC):
        raise BagError(
            f"bag {path} is cut off: its end with the index is missing, as where a recorder was "
            "killed; `mcap recover` saves what it holds"
        )


Found = tuple[dict[int, RecordedChannel], list[ChunkPlace]]


def _stated(summary: Summary | None) -> Found | None:
    """What the end of the file states; None where that does not lead to every message."""
    if summary is None or not summary.chunk_indexes:
        return None
    chunks = [
        ChunkPlace(
            chunk.message_start_time,
            chunk.message_end_time,
            chunk.chunk_start_offset + RECORD.size,
            chunk.chunk_length - RECORD.size,
            True,
            frozenset(chunk.message_index_offsets),
        )
        for chunk in summary.chunk_indexes
    ]
    named = {channel for chunk in chunks for channel in chunk.channels}
    if not all(chunk.channels for chunk in chunks) or not named <= summary.channels.keys():
        return None
    names = {schema.id: schema.name for schema in summary.schemas.values()}
    return _of_ros(summary.channels, names), chunks


def _of_ros(
    channels: Mapping[int, Channel], names: Mapping[int, str]
) -> dict[int, RecordedChannel]:
    return {
        channel.id: RecordedChannel(channel.topic, names.get(channel.schema_id, ""))
        for channel in channels.values()
        if channel.message_encoding == ENCODING
    }


def _walked(file: IO[bytes]) -> Found:
    """What lies in the file from its begin to its end."""
    walk = _Walk()
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for code, content, end in records(data, len(MAGIC)):
            if code == DATA_END:
                break
            if end > len(data):
                raise ValueError(f"the record at byte {content} ends behind the file")
            walk.take(data, code, content, end)
    return _of_ros(walk.channels, walk.names), walk.chunks


class _Walk:
    """Takes note of every record."""

    def __init__(self) -> None:
        self.channels: dict[int, Channel] = {}
        self.names: dict[int, str] = {}
        self.chunks: list[ChunkPlace] = []

    def take(self, data: bytes | mmap.mmap, code: int, content: int, end: int) -> None:
        """A record of the file.

        Args:
            data: Of the file.
            code: What it is.
            content: Its first byte.
            end: The byte behind it.
        """
        if code == MESSAGE:
            channel, _, time, _ = MESSAGE_HEAD.unpack_from(data, content)
            self._add(time, content - RECORD.size, end, channel)
        elif code == CHUNK:
            inner = unpacked(data[content:end])
            heads = []
            for kind, begin, behind in records(inner):
                if kind == MESSAGE:
                    heads.append(MESSAGE_HEAD.unpack_from(inner, begin))
                else:
                    self._describe(inner, kind, begin, behind)
            if heads:
                times = [head[2] for head in heads]
                channels = frozenset(head[0] for head in heads)
                place = ChunkPlace(min(times), max(times), content, end - content, True, channels)
                self.chunks.append(place)
        else:
            self._describe(data, code, content, end)

    def _describe(self, data: bytes | mmap.mmap, code: int, content: int, end: int) -> None:
        if code == SCHEMA:
            schema = Schema.read(_stream(data[content:end]))
            self.names[schema.id] = schema.name
        elif code == CHANNEL:
            channel = Channel.read(_stream(data[content:end]))
            self.channels[channel.id] = channel

    def _add(self, time: int, begin: int, end: int, channel: int) -> None:
        """A message outside of chunks, to the run of the one before where that is not full."""
        last = self.chunks[-1] if self.chunks else None
        if last is None or last.packed or end - last.offset > RUN:
            run = ChunkPlace(time, time, begin, end - begin, False, frozenset([channel]))
            self.chunks.append(run)
            return
        channels = last.channels if channel in last.channels else last.channels | {channel}
        self.chunks[-1] = ChunkPlace(
            min(time, last.start),
            max(time, last.end),
            last.offset,
            end - last.offset,
            False,
            channels,
        )


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))
