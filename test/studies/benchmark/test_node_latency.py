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

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.benchmark.node_latency import (
    RoundTrips,
    node_latency,
    watched_latency,
)


@pytest.fixture
def configuration():
    return load_configuration("small_uav", scenario="crosswind")


def assert_timed(*rows):
    for row in rows:
        assert row["count"] > 0  # how many, the machine decides
        assert 0.0 < row["median"] <= row["p99"] <= row["max"]


@pytest.mark.nodes
def test_states_are_answered_and_the_echo_by_as_many_commands(configuration):
    heard = []
    study = node_latency(configuration, 2.0, heard.append)
    results = study.content
    controller, echo = results["state_to_command_us"], results["echo_us"]
    assert_timed(controller, echo)
    assert results["ratio"] == controller["median"] / echo["median"]
    assert 0.0 < results["controller_cpu_share"] < 1.0
    assert heard
    words = "\n".join(study.words)
    assert f"{controller['median']:.0f} us" in words
    assert f"ratio {results['ratio']:.2f}" in words


@pytest.mark.nodes
def test_a_command_counts_for_the_state_that_was_sent_last():
    trips = RoundTrips()
    trips.send(1)
    trips.send(2)
    trips.arrive(1)
    assert not trips.times
    trips.arrive(2)
    ((began, duration),) = trips.times
    assert began > 0.0
    assert duration >= 0.0


LONG = 600.0  # s


@pytest.mark.nodes
@pytest.mark.long
def test_a_flight_is_timed_with_and_without_a_page(configuration):
    pytest.importorskip("viser")
    heard = []
    study = watched_latency(configuration, [1], 2.0, heard.append, turns=1)
    (flight,) = study.content["view"]
    assert_timed(flight["without_us"], flight["with_us"])
    assert flight["median_ratio"] == flight["with_us"]["median"] / flight["without_us"]["median"]
    assert flight["page_cpu_share"] > 0.0
    assert flight["page_memory_mb"] > 10.0
    assert flight["messages_hz"] > 0.0  # what is drawn has reached its client
    assert heard
    words = "\n".join(study.words)
    assert "1 aircraft" in words
    assert f"ratio of medians {flight['median_ratio']:.3f}" in words


@pytest.mark.nodes
@pytest.mark.long
def test_a_long_view_grows_by_less_than_20_mb(configuration):
    pytest.importorskip("viser")
    study = watched_latency(configuration, [1], LONG, print, turns=1)
    print("\n".join(study.words))
    assert study.content["view"][0]["page_growth_mb"] < 20.0
