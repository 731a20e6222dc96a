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

"""Messages of one topic, found by when they were heard or by their stamps."""

import struct

import pytest
from recorded_bag import COMMAND_DELAY, WALL, rewritten, write_bag

from uav_tracking_mpc.view.recorded.bag_chunks import BagChunks
from uav_tracking_mpc.view.recorded.bag_index import read_index
from uav_tracking_mpc.view.recorded.recorded_topic import RecordedTopic, header_stamp

PERIOD = 100_000_000  # ns between commands
START = 5_000_000_000  # ns


@pytest.fixture(scope="module")
def commands(tmp_path_factory):
    """Of a bag with few messages in a chunk; stamps and times of the recorder differ."""
    folder = tmp_path_factory.mktemp("bag")
    write_bag(folder / "flight.mcap", 4.0, state_rate=20, command_rate=10, start=START)
    return topic(rewritten(folder / "flight.mcap", folder / "small.mcap", chunk_size=20_000))


def topic(path, name="/uav/command"):
    index = read_index(path)
    names = {k: channel.topic for k, channel in index.channels.items()}
    return RecordedTopic(name, index, BagChunks(index, names))


@pytest.mark.parametrize("k", [0, 1, 17, 40])
def test_the_newest_message_is_the_last_that_was_heard(commands, k):
    time = WALL + k * PERIOD + COMMAND_DELAY
    place = commands.newest(time)
    assert commands.heard(place) == time
    assert commands.newest(time + PERIOD - 1) == (place if k < 40 else commands.last)
    assert commands.stamp(place) == START + k * PERIOD


def test_before_the_first_message_there_is_none(commands):
    assert commands.newest(WALL) is None
    assert commands.newest_stamped(START - 1) is None
    assert commands.before(commands.first) is None


@pytest.mark.parametrize("k", [0, 1, 17, 40])
def test_a_message_is_found_by_its_stamp(commands, k):
    stamp = START + k * PERIOD
    assert commands.stamp(commands.newest_stamped(stamp)) == stamp
    assert commands.stamp(commands.newest_stamped(stamp + PERIOD // 2)) == stamp


def test_messages_are_walked_through_backwards(commands):
    place, stamps = commands.last, []
    while place is not None:
        stamps.append(commands.stamp(place))
        place = commands.before(place)
    assert stamps == [START + k * PERIOD for k in reversed(range(41))]


def test_samples_are_spread_over_the_record(commands):
    stamps = [commands.stamp(place) for place in commands.sample(4)]
    assert len(stamps) >= 4
    assert stamps == sorted(set(stamps))
    assert stamps[0] == START


@pytest.mark.parametrize(("order", "mark"), [("<", 1), (">", 0)])
def test_a_stamp_is_read_in_either_byte_order(order, mark):
    data = b"xyz" + bytes([0, mark, 0, 0]) + struct.pack(f"{order}iI", 7, 8)
    assert header_stamp(data, 3) == 7_000_000_008
