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

"""The aircraft of a bag, found by their topics, with the limits that lie beside it."""

import json
import subprocess
import sys
from dataclasses import asdict

import numpy as np
import pytest
from mcap.writer import CompressionType
from recorded_bag import SyntheticFlight, rewritten, write_bag

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, TARGET
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.recorded.bag_index import BagError
from uav_tracking_mpc.view.recorded.recorded_source import RecordedSource

RATES = {"state_rate": 20, "command_rate": 10}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "mission.mcap"
    write_bag(path, 4.0, **RATES)
    return path


def test_several_aircraft_are_several_flights(tmp_path):
    write_bag(tmp_path / "two.mcap", 4.0, namespaces=("blue", "fleet/red"), **RATES)
    source = RecordedSource(tmp_path / "two.mcap")
    source.clock.pause()
    source.clock.seek(2.0)
    assert [flight.name for flight in source.flights()] == ["blue", "fleet_red"]
    for flight, turn in zip(source.flights(), (0.0, 2.0), strict=True):
        sight = flight.sight
        expected = SyntheticFlight(turn).vehicle(2.0)[:3]
        np.testing.assert_allclose(sight.position, expected, atol=1e-9)
        assert {status.node for status in sight.statuses} == {
            "nmpc_controller", "uav_simulator", "target_publisher",
        }  # fmt: skip


@pytest.mark.parametrize(
    "options",
    [{"compression": CompressionType.LZ4}, {"use_chunking": False}],
    ids=["lz4", "unchunked"],
)
def test_bags_of_other_recorders_show_the_same(tmp_path, bag, options):
    sights = []
    for path in (bag, rewritten(bag, tmp_path / "other.mcap", **options)):
        source = RecordedSource(path)
        sights.append(source.flights()[0].at(2.0))
    ours, theirs = sights
    np.testing.assert_array_equal(ours.position, theirs.position)
    np.testing.assert_array_equal(ours.plan, theirs.plan)
    assert ours.statuses == theirs.statuses
    assert (ours.time, ours.errors, ours.cost) == (theirs.time, theirs.errors, theirs.cost)


def test_a_bag_without_an_aircraft_is_refused(tmp_path):
    path = tmp_path / "other.mcap"
    write_bag(path, 1.0, **RATES, topics=(TARGET, AIR_VELOCITY))
    with pytest.raises(BagError, match=r"holds no aircraft.*uav/odometry.*/target/position") as no:
        RecordedSource(path)
    assert str(path) in str(no.value)
    assert "\n" not in str(no.value)


def test_limits_are_those_that_the_controller_recorded_beside_the_bag(tmp_path, bag):
    path = tmp_path / "mission.mcap"
    path.write_bytes(bag.read_bytes())
    assert RecordedSource(path).flights()[0].tracking is None
    flown = load_configuration("small_uav", ["nmpc_controller.range=333.0"]).controller
    header = json.dumps({"version": "1", "parameters": asdict(flown)})
    (tmp_path / "controller.jsonl").write_text(f"{header}\n")
    assert RecordedSource(path).flights()[0].tracking == flown
    told = load_configuration("small_uav").controller
    assert RecordedSource(path, told).flights()[0].tracking is told


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"parameters": {"range": -1}}', "no json"])
def test_a_record_that_cannot_be_read_is_left_out_and_logged(tmp_path, bag, caplog, content):
    path = tmp_path / "mission.mcap"
    path.write_bytes(bag.read_bytes())
    (tmp_path / "controller.jsonl").write_text(content)
    assert RecordedSource(path).flights()[0].tracking is None
    assert "controller.jsonl" in caplog.text


WITHOUT_ROS = """
import sys
for name in sys.argv[2:]:
    sys.modules[name] = None
from pathlib import Path
from uav_tracking_mpc.view.recorded.recorded_source import RecordedSource
sight = RecordedSource(Path(sys.argv[1])).flights()[0].at(2.0)
print(sight.time, sight.mode.value, len(sight.plan), len(sight.statuses), sorted(sight.errors)[0])
"""


def test_a_bag_is_shown_without_ros(bag):
    missing = [
        "rclpy", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs",
        "rcl_interfaces", "rosgraph_msgs", "sensor_msgs", "std_msgs", "trajectory_msgs",
        "visualization_msgs",
    ]  # fmt: skip
    words = [sys.executable, "-c", WITHOUT_ROS, str(bag), *missing]
    finished = subprocess.run(words, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.split() == [
        "2.0", "optimal", "plan", "20", "3", "altitude_error",
    ]  # fmt: skip
