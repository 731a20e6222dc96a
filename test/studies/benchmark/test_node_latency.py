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

"""Real nodes and the echo between them are timed, and put into words."""

import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.benchmark.node_latency import in_words, node_latency

FAST = ["nmpc_controller.control_rate=50.0", "uav_simulator.state_rate=50.0"]


@pytest.mark.nodes
@pytest.mark.alone
def test_states_are_answered_and_the_echo_by_as_many_commands():
    heard = []
    results = node_latency(load_configuration("small_uav", FAST, "crosswind"), 2.0, heard.append)
    controller, echo = results["state_to_command_us"], results["echo_us"]
    for row in (controller, echo):
        assert row["count"] > 0  # how many, the machine decides
        assert 0.0 < row["median"] <= row["p99"] <= row["max"]
    assert results["ratio"] == controller["median"] / echo["median"] > 1.0
    assert 0.0 < results["controller_cpu_share"] < 1.0
    assert heard
    words = "\n".join(in_words(results))
    assert f"{controller['median']:.0f} us" in words
    assert f"ratio {results['ratio']:.2f}" in words


@pytest.mark.nodes
def test_a_command_counts_for_the_state_that_was_sent_last():
    from uav_tracking_mpc.studies.benchmark.echo import RoundTrips  # needs ROS

    trips = RoundTrips()
    trips.send(1)
    trips.send(2)
    trips.arrive(1)
    assert not trips.times
    trips.arrive(2)
    assert len(trips.times) == 1
    assert trips.times[0] >= 0.0
