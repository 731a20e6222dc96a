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

"""Chunks are unpacked when they are looked at, and few of them stay in memory."""

import logging

import pytest
from mcap.writer import Writer
from recorded_bag import rewritten, write_bag

from uav_tracking_mpc.view.recorded import bag_chunks
from uav_tracking_mpc.view.recorded.bag_chunks import BagChunks
from uav_tracking_mpc.view.recorded.bag_index import read_index


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bag")
    write_bag(folder / "flight.mcap", 4.0, state_rate=20, command_rate=10)
    return rewritten(folder / "flight.mcap", folder / "small.mcap", chunk_size=20_000)


def reader(path):
    index = read_index(path)
    return index, BagChunks(index, {k: channel.topic for k, channel in index.channels.items()})


@pytest.mark.parametrize("options", [{}, {"use_chunking": False}], ids=["chunks", "unchunked"])
def test_every_message_is_found_once(tmp_path, bag, options):
    index, chunks = reader(rewritten(bag, tmp_path / "other.mcap", **options))
    heard = [
        time
        for number in range(len(index.chunks))
        for time in chunks.messages(number).heard.get("/uav/odometry", [])
    ]
    assert len(heard) == 81
    assert heard == sorted(set(heard))


def test_memory_is_bounded(bag, monkeypatch):
    index, chunks = reader(bag)
    sizes = [len(chunks.messages(number).data) for number in range(len(index.chunks))]
    limit = 3 * max(sizes)
    monkeypatch.setattr(bag_chunks, "KEPT", limit)
    index, chunks = reader(bag)
    for number in range(len(index.chunks)):
        chunks.messages(number)
        assert sum(len(kept.data) for kept in chunks._read.values()) <= limit
    assert len(chunks._read) < len(index.chunks)


def test_what_was_looked_at_last_stays(bag):
    _, chunks = reader(bag)
    assert chunks.messages(1) is chunks.messages(1)


def test_a_damaged_chunk_holds_nothing_and_is_logged(tmp_path, bag, caplog):
    path, data = tmp_path / "damaged.mcap", bytearray(bag.read_bytes())
    place = read_index(bag).chunks[2]
    middle = place.offset + place.size // 2
    data[middle : middle + 200] = bytes(200)
    path.write_bytes(data)
    _, chunks = reader(path)
    with caplog.at_level(logging.WARNING):
        assert not chunks.messages(2).heard
    assert str(path) in caplog.text
    assert chunks.messages(3).heard


def test_messages_of_several_senders_are_in_order(tmp_path):
    path = tmp_path / "two.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        kind = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        senders = [writer.register_channel("/value", "cdr", kind, {"of": k}) for k in "ab"]
        for sender, time in ((0, 10), (0, 30), (1, 20), (1, 40)):
            writer.add_message(senders[sender], time, b"%d" % time, time)
        writer.finish()
    _, chunks = reader(path)
    found = chunks.messages(0)
    assert found.heard["/value"] == [10, 20, 30, 40]
    assert [found.data[begin:end] for begin, end in found.spans["/value"]] == [
        b"10", b"20", b"30", b"40",
    ]  # fmt: skip
