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

"""A record of two hours is opened and followed by a few of its chunks.

Prints what it takes: ``pytest -m long -s test/view/recorded/test_long_record.py``.
"""

import resource
import time

import pytest
from recorded_bag import lengthen, write_bag

from uav_tracking_mpc.view.recorded.bag_chunks import KEPT, BagChunks
from uav_tracking_mpc.view.recorded.recorded_source import RecordedSource

HOURS = 2.0
JUMPS = (6543.2, 17.0, 3600.0, 5000.0, 1234.5, 7199.0)  # s
OPENED, JUMPED = 40, 90  # chunks: samples and ends; two minutes of a track and what leads to it


@pytest.fixture
def unpacked(monkeypatch):
    """Numbers of the chunks that were unpacked."""
    numbers, load = [], BagChunks._load

    def noted(self, number):
        numbers.append(number)
        return load(self, number)

    monkeypatch.setattr(BagChunks, "_load", noted)
    return numbers


def measured(words, function):
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{words}: {wall:.2f} s, {cpu:.2f} s of CPU, at most {memory:.0f} MB so far")
    return result


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_two_hours_take_a_few_chunks(tmp_path, unpacked):
    write_bag(tmp_path / "short.mcap", 120.0)
    path = tmp_path / "long.mcap"
    lengthen(tmp_path / "short.mcap", path, round(HOURS * 30))
    print(f"\n{path.stat().st_size / 1e6:.0f} MB for {HOURS:g} hours")
    source = measured("open", lambda: RecordedSource(path))
    assert source.clock.end >= HOURS * 3600.0
    assert len(source._chunks._index.chunks) > 1000
    assert len(unpacked) <= OPENED
    source.clock.pause()
    (flight,) = source.flights()
    for jump in JUMPS:
        unpacked.clear()
        source.clock.seek(jump)
        sight = measured(f"sight at {jump:g} s", lambda: flight.sight)
        past = measured("  its last two minutes", lambda: flight.past(120.0))
        assert jump - 0.041 < sight.time <= jump
        assert past[0].time <= max(jump - 119.0, 0.5)
        assert len(unpacked) <= JUMPED
        assert sum(len(kept.data) for kept in source._chunks._read.values()) <= KEPT
    source.close()
