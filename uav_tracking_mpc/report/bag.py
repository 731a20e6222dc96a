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

"""Messages of bags of ROS 2, in order, without ROS: MCAP and sqlite, one file or a folder."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from uav_tracking_mpc.parameters.specification import ParameterError

ROOMS = (0, 4, 8, 12)  # bytes

_room: dict[tuple[str, int], int] = {}  # bytes, by type and size


@functools.cache
def typestore() -> Typestore:
    """The messages of ROS 2 Jazzy; made once, for that takes a while."""
    return get_typestore(Stores.ROS2_JAZZY)


class BagError(ParameterError):
    """A file cannot be read as a bag; the text names it and says why."""


def messages(path: Path, names: Iterable[str]) -> Iterator[tuple[str, int, Any]]:
    """Messages of some topics, in the order in which they were heard.

    Args:
        path: A file ``.mcap``, or the folder of a bag.
        names: Of the topics; see :func:`name_of`.

    Yields:
        Which of the names, time in [ns] at which it was heard, and message, of each.

    Raises:
        BagError: It is no bag.
    """
    try:
        with AnyReader([path], default_typestore=typestore()) as reader:
            found = {each.id: name_of(each.topic, names) for each in reader.connections}
            wanted = [each for each in reader.connections if found[each.id] is not None]
            for connection, heard, data in reader.messages(wanted):
                yield found[connection.id] or "", heard, decoded(data, connection.msgtype)
    except (AnyReaderError, FileNotFoundError) as error:
        raise BagError(f"{path} cannot be read as a bag: {error}") from error


def name_of(topic: str, names: Iterable[str]) -> str | None:
    """Which of some names a topic has: an absolute one as it is, a relative one in any namespace.

    Args:
        topic: As a bag calls it.
        names: To choose from.
    """
    path = f"/{topic.lstrip('/')}"
    for name in names:
        if path == name or (not name.startswith("/") and path.endswith(f"/{name}")):
            return name
    return None


def decoded(data: bytes | memoryview, kind: str) -> Any:
    """A message, with the names of its fields in ROS.

    Fast DDS leaves room for numbers behind each empty sequence of them, which rosbags takes for a
    message of another type: there it is the message without its last bytes.

    Args:
        data: Serialized.
        kind: Type as ROS writes it, such as ``nav_msgs/msg/Odometry``.

    Raises:
        ValueError: It is no such message.
    """
    known = _room.get((kind, len(data)), 0)
    for room in (known, *(room for room in ROOMS if room != known)):
        try:
            message = typestore().deserialize_cdr(data[: len(data) - room], kind)
        except Exception:  # whatever it says of such bytes
            continue
        _room[kind, len(data)] = room
        return message
    raise ValueError(f"{len(data)} bytes are no {kind}")
