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

"""A flight is timed without and with a page that is watched, and both are put into words.

``pytest -m long -s test/studies/benchmark/test_watched_latency.py`` watches one for ten minutes,
``uav_tracking benchmark --nodes --view 3600`` for an hour.
"""

import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.benchmark.watched_latency import in_words, watched_latency

LONG = 600.0  # s
FAST = ["nmpc_controller.control_rate=50.0", "uav_simulator.state_rate=50.0"]


@pytest.mark.nodes
@pytest.mark.alone
def test_two_aircraft_are_timed_with_and_without_a_page():
    pytest.importorskip("viser")
    heard = []
    configuration = load_configuration("small_uav", FAST, "crosswind")
    (flight,) = watched_latency(configuration, [2], 2.0, heard.append, turns=1)
    for row in (flight["without_us"], flight["with_us"]):
        assert row["count"] > 20
        assert 0.0 < row["median"] <= row["p99"] <= row["max"]
    assert flight["median_ratio"] == flight["with_us"]["median"] / flight["without_us"]["median"]
    assert flight["page_cpu_share"] > 0.0
    assert flight["page_memory_mb"] > 10.0
    assert flight["messages_hz"] > 0.0  # what is drawn has reached its client
    assert heard
    words = "\n".join(in_words([flight]))
    assert "2 aircraft" in words
    assert f"ratio of medians {flight['median_ratio']:.3f}" in words


@pytest.mark.nodes
@pytest.mark.long
@pytest.mark.timeout(0)
def test_a_long_view_grows_by_less_than_20_mb():
    pytest.importorskip("viser")
    configuration = load_configuration("small_uav", FAST, "crosswind")
    flights = watched_latency(configuration, [1], LONG, print, turns=1)
    print("\n".join(in_words(flights)))
    assert flights[0]["page_growth_mb"] < 20.0
