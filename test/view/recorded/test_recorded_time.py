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

"""Time of a record is that of its stamps, from the first command on."""

import pytest
from recorded_bag import SECOND, rewritten, write_bag

from uav_tracking_mpc.view.recorded.bag_chunks import BagChunks
from uav_tracking_mpc.view.recorded.bag_index import read_index
from uav_tracking_mpc.view.recorded.recorded_time import RecordedTime
from uav_tracking_mpc.view.recorded.recorded_topic import RecordedTopic

RATES = {"state_rate": 20, "command_rate": 10}


def opened(path):
    index = read_index(path)
    chunks = BagChunks(index, {k: channel.topic for k, channel in index.channels.items()})
    states, commands = (
        RecordedTopic(name, index, chunks) for name in ("/uav/odometry", "/uav/command")
    )
    return states, RecordedTime([states], [commands])


def small(folder, **options):
    write_bag(folder / "flight.mcap", 4.0, **RATES, **options)
    return rewritten(folder / "flight.mcap", folder / "small.mcap", chunk_size=20_000)


@pytest.mark.parametrize("speed", [1.0, 5.0])
def test_simulated_time_counts_however_fast_it_ran(tmp_path, speed):
    states, time = opened(small(tmp_path, speed=speed, start=3 * SECOND))
    assert (time.clock.begin, time.clock.end) == (0.0, 4.0)
    for wanted in (0.0, 0.05, 1.23, 3.999, 4.0):
        at = time.seconds(time.moment(states, time.newest(states, wanted)))
        assert wanted - 0.05 < at <= wanted


def test_it_counts_from_the_first_command(tmp_path):
    states, time = opened(small(tmp_path, silence=[(0.0, 1.0)]))
    assert (time.clock.begin, time.clock.end) == (-1.0, 3.0)
    assert time.newest(states, -1.01) is None


@pytest.mark.parametrize("stamp", [0, None], ids=["none", "begin anew"])
def test_where_stamps_do_not_rise_it_is_the_recorders(tmp_path, monkeypatch, stamp):
    """A driver that does not stamp, or a simulator that was started anew in the middle."""
    path = small(tmp_path, speed=2.0)
    original = RecordedTopic.stamp

    def read(self, place):
        found = original(self, place)
        return found % (2 * SECOND) if stamp is None else stamp

    monkeypatch.setattr(RecordedTopic, "stamp", read)
    states, time = opened(path)
    assert time.clock.end - time.clock.begin == pytest.approx(2.0)
    at = time.seconds(time.moment(states, time.newest(states, 1.0)))
    assert 1.0 - 0.025 < at <= 1.0
