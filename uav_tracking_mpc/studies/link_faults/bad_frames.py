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

"""Frames that are none: garbled, cut, with bytes between; what a connection makes of them."""

from __future__ import annotations

import random
import time

from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink

SENDER = 3  # MAVLink system of the good frames


def changed(random_: random.Random, good: bytes) -> bytes:
    """A frame with some bytes changed, cut off, missing or put in between; never the same.

    Args:
        random_: Where all that is random comes from.
        good: The frame.
    """
    while (bad := _changed(random_, good)) == good:
        pass
    return bad


def _changed(random_: random.Random, good: bytes) -> bytes:
    frame = bytearray(good)
    kind = random_.randrange(5)
    if kind == 0:
        for _ in range(random_.randrange(1, 6)):
            frame[random_.randrange(len(frame))] ^= random_.randrange(1, 256)
    elif kind == 1:
        del frame[random_.randrange(1, len(frame)) :]
    elif kind == 2:
        place = random_.randrange(len(frame))
        frame[place:place] = random_.randbytes(random_.randrange(1, 30))
    elif kind == 3:
        frame = bytearray(random_.randbytes(random_.randrange(1, 300)))
    else:
        start = random_.randrange(len(frame))
        del frame[start : start + random_.randrange(1, 8)]
    return bytes(frame)


def read_bad_frames(connection: Connection, count: int, seed: int) -> dict[str, float]:
    """Bad frames, each followed by a good one, as a connection reads them.

    Args:
        connection: Of datagrams; nothing is sent.
        count: Of bad frames.
        seed: Of everything random.

    Returns:
        ``bad``: how many; ``taken``: of them for messages, the checksum of 16 bits lets one in
        65 536 pass; ``good_lost``: good ones that were not read; ``bad_us`` and ``good_us``: time
        for one in [us].
    """
    random_, sender = random.Random(seed), mavlink.MAVLink(None, SENDER, 1)
    heartbeat = mavlink.MAVLink_heartbeat_message(1, 3, 128, 15, mavlink.MAV_STATE_ACTIVE, 3)
    taken = lost = 0
    bad_time = good_time = 0.0
    for _ in range(count):
        good = bytes(heartbeat.pack(sender))
        sender.seq = (sender.seq + 1) % 256
        bad = changed(random_, good)
        begin = time.perf_counter()
        passed = connection.parse(bad)
        middle = time.perf_counter()
        read = connection.parse(good)
        good_time += time.perf_counter() - middle
        bad_time += middle - begin
        # A frame with bytes put before or after it is still a good one.
        taken += sum(message.to_dict() != heartbeat.to_dict() for message in passed)
        lost += [message.to_dict() for message in read] != [heartbeat.to_dict()]
    return {
        "bad": count,
        "taken": taken,
        "good_lost": lost,
        "bad_us": 1e6 * bad_time / count,
        "good_us": 1e6 * good_time / count,
    }
