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

"""What a bag states of itself, or shows when it is walked through, whoever wrote it."""

import pytest
from mcap.writer import CompressionType, IndexType
from recorded_bag import WALL, rewritten, write_bag

from uav_tracking_mpc.view.recorded.bag_index import BagError, read_index


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "flight.mcap"
    write_bag(path, 4.0, state_rate=20, command_rate=10)
    return path


def topics(index, chunk):
    return {index.channels[channel].topic for channel in chunk.channels}


def test_the_index_names_topics_and_times(bag):
    index = read_index(bag)
    assert {channel.topic: channel.kind for channel in index.channels.values()}[
        "/uav/odometry"
    ] == "nav_msgs/msg/Odometry"
    assert index.chunks[0].start == WALL
    assert max(chunk.end for chunk in index.chunks) >= WALL + 4_000_000_000
    assert {"/uav/odometry", "/uav/command", "/diagnostics"} <= topics(index, index.chunks[0])


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.NONE},
        {"use_chunking": False},
        {"index_types": IndexType.CHUNK},
        {"index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False},
        {"repeat_channels": False, "repeat_schemas": False},
    ],
    ids=["lz4", "plain", "unchunked", "no message index", "no index", "no channels at the end"],
)
def test_bags_of_other_recorders_hold_the_same(tmp_path, bag, options):
    index = read_index(rewritten(bag, tmp_path / "other.mcap", **options))
    whole = read_index(bag)
    held = {channel for chunk in whole.chunks for channel in topics(whole, chunk)}
    assert {channel for chunk in index.chunks for channel in topics(index, chunk)} == held
    assert min(chunk.start for chunk in index.chunks) == min(c.start for c in whole.chunks)
    assert max(chunk.end for chunk in index.chunks) == max(c.end for c in whole.chunks)


def test_chunks_lie_in_the_order_of_their_times(tmp_path, bag):
    index = read_index(rewritten(bag, tmp_path / "small.mcap", chunk_size=20_000))
    starts = [chunk.start for chunk in index.chunks]
    assert len(starts) > 5
    assert starts == sorted(starts)


def _cut(data):
    return data[: len(data) // 2]


def _garbled(data):
    """The index at the end, without the footer and what is before it."""
    return data[:-2000] + bytes(1900) + data[-100:]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: b"", "is empty: 0 bytes"),
        (lambda data: b"time,range\n1,2\n" * 40, "is no bag"),
        (lambda data: data[:8], "is cut off"),
        (_cut, "is cut off.*mcap recover"),
        (_garbled, "is damaged"),
    ],
    ids=["empty", "text", "begin alone", "cut", "garbled"],
)
def test_a_file_that_is_no_whole_bag_is_named_in_one_line(tmp_path, bag, change, words):
    path = tmp_path / "broken.mcap"
    path.write_bytes(change(bag.read_bytes()))
    with pytest.raises(BagError, match=words) as caught:
        read_index(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_bag_without_messages_is_refused(tmp_path, bag):
    path = tmp_path / "none.mcap"
    write_bag(path, 1.0, topics=())
    with pytest.raises(BagError, match="holds no message"):
        read_index(path)
