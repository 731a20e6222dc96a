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

"""Messages are found by topic and time, whoever wrote the bag; few chunks stay in memory."""

import logging
import struct

import pytest
from mcap.writer import CompressionType, IndexType, Writer
from recorded_bag import COMMAND_DELAY, WALL, rewritten, write_bag

from uav_tracking_mpc.report import bag_index as bags
from uav_tracking_mpc.report.bag import BagError
from uav_tracking_mpc.report.bag_index import Bag, BagTopic, header_stamp

PERIOD = 100_000_000  # ns between commands
START = 5_000_000_000  # ns
OTHERS = {
    "lz4": {"compression": CompressionType.LZ4},
    "plain": {"compression": CompressionType.NONE},
    "unchunked": {"use_chunking": False},
    "no message index": {"index_types": IndexType.CHUNK},
    "no index": {"index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False},
    "no channels at the end": {"repeat_channels": False, "repeat_schemas": False},
}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """With few messages in a chunk; stamps and times of the recorder differ."""
    folder = tmp_path_factory.mktemp("bag")
    write_bag(folder / "flight.mcap", 4.0, state_rate=20, command_rate=10, start=START)
    return rewritten(folder / "flight.mcap", folder / "small.mcap", chunk_size=20_000)


@pytest.fixture(scope="module")
def commands(bag):
    return BagTopic(Bag(bag), "/uav/command")


def walked(topic):
    """Every place, from the last to the first."""
    place = topic.last
    while place is not None:
        yield place
        place = topic.before(place)


def test_the_index_names_topics_and_times(bag):
    opened = Bag(bag)
    assert opened.kinds["/uav/odometry"] == "nav_msgs/msg/Odometry"
    starts = [chunk.index.message_start_time for chunk in opened.chunks]
    assert starts[0] == WALL and len(starts) > 5
    assert starts == sorted(starts)
    assert {"/uav/odometry", "/uav/command", "/diagnostics"} <= set().union(
        *(chunk.topics for chunk in opened.chunks)
    )


@pytest.mark.parametrize("options", OTHERS.values(), ids=OTHERS)
def test_bags_of_other_recorders_hold_the_same(tmp_path, bag, options):
    """Each message once, in the order in which it was heard."""
    whole, other = Bag(bag), Bag(rewritten(bag, tmp_path / "other.mcap", **options))
    held = {name for chunk in whole.chunks for name in chunk.topics}
    assert {name for chunk in other.chunks for name in chunk.topics} == held
    ours, theirs = (BagTopic(each, "/uav/odometry") for each in (whole, other))
    heard = [ours.time(place) for place in walked(ours)]
    assert len(heard) == 81 and heard == sorted(set(heard), reverse=True)
    assert [theirs.time(place) for place in walked(theirs)] == heard
    assert str(theirs.message(theirs.last)) == str(ours.message(ours.last))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: b"", "is empty: 0 bytes"),
        (lambda data: b"time,range\n1,2\n" * 40, "is no bag"),
        (lambda data: data[:8], "is cut off"),
        (lambda data: data[: len(data) // 2], "is cut off.*mcap recover"),
        (lambda data: data[:-2000] + bytes(1900) + data[-100:], "is damaged"),
    ],
    ids=["empty", "text", "begin alone", "cut", "index garbled"],
)
def test_a_file_that_is_no_whole_bag_is_named_in_one_line(tmp_path, bag, change, words):
    path = tmp_path / "broken.mcap"
    path.write_bytes(change(bag.read_bytes()))
    with pytest.raises(BagError, match=words) as caught:
        Bag(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_memory_is_bounded(bag, monkeypatch):
    largest = max(chunk.index.uncompressed_size for chunk in Bag(bag).chunks)
    monkeypatch.setattr(bags, "KEPT", 3 * largest)
    opened = Bag(bag)
    for number in range(len(opened.chunks)):
        opened.unpacked(number)
    assert opened.unpacked.cache_info().currsize == 3 < len(opened.chunks)
    assert opened.unpacked(number) is opened.unpacked(number)


@pytest.mark.parametrize("part", ["chunk", "message index"])
def test_a_damaged_chunk_holds_nothing_and_is_logged(tmp_path, bag, caplog, part):
    """Where the messages of a chunk lie is found in the chunk itself."""
    path, data, index = tmp_path / "damaged.mcap", bytearray(bag.read_bytes()), None
    index = Bag(bag).chunks[2].index
    begin = index.chunk_start_offset + index.chunk_length // 2
    if part == "message index":
        begin = min(index.message_index_offsets.values()) + 20
    data[begin : begin + 200] = b"\xff" * 200
    path.write_bytes(data)
    opened = Bag(path)
    with caplog.at_level(logging.WARNING):
        assert bool(opened.unpacked(2)) is (part != "chunk")
    assert (str(path) in caplog.text) is (part == "chunk")
    assert opened.unpacked(3)


def test_messages_of_several_senders_are_in_order(tmp_path):
    path = tmp_path / "two.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        kind = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        senders = [writer.register_channel("/value", "cdr", kind, {"of": k}) for k in "ab"]
        for sender, time in ((0, 10), (0, 30), (1, 20), (1, 40)):
            data = struct.pack("<4xd", time)
            writer.add_message(senders[sender], time, b"\0\1" + data[2:], time)
        writer.finish()
    topic = BagTopic(Bag(path), "/value")
    found = [(topic.time(place), topic.message(place).data) for place in walked(topic)]
    assert found == [(40, 40.0), (30, 30.0), (20, 20.0), (10, 10.0)]


@pytest.mark.parametrize("k", [0, 1, 17, 40])
def test_the_newest_message_is_the_last_at_a_time(commands, k):
    time, stamp = WALL + k * PERIOD + COMMAND_DELAY, START + k * PERIOD
    place = commands.newest(time)
    assert (commands.time(place), commands.time(place, stamped=True)) == (time, stamp)
    assert commands.newest(time + PERIOD - 1) == (place if k < 40 else commands.last)
    assert commands.newest(stamp, stamped=True) == place
    assert commands.newest(stamp + PERIOD // 2, stamped=True) == place


def test_before_the_first_message_there_is_none(commands):
    assert commands.newest(WALL) is None
    assert commands.newest(START - 1, stamped=True) is None
    assert commands.before(commands.first) is None


def test_messages_are_walked_through_backwards_and_sampled(commands):
    stamps = [commands.time(place, stamped=True) for place in walked(commands)]
    assert stamps == [START + k * PERIOD for k in reversed(range(41))]
    sampled = [commands.time(place, stamped=True) for place in commands.sample(4)]
    assert len(sampled) >= 4 and sampled[0] == START
    assert sampled == sorted(set(sampled))


def test_a_message_that_is_too_short_for_a_stamp_has_none():
    assert header_stamp(b"\x00\x01\x00\x00\x01") == 0


@pytest.mark.parametrize(("order", "mark"), [("<", 1), (">", 0)])
def test_a_stamp_is_read_in_either_byte_order(order, mark):
    assert header_stamp(bytes([0, mark, 0, 0]) + struct.pack(f"{order}iI", 7, 8)) == 7_000_000_008
