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
from uav_tracking_mpc.view.recorded.bag_index import BagError, read_index
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


@pytest.fixture
def folder(tmp_path, bag):
    """As `ros2 bag record` splits it, after 1.5 s."""
    folder = tmp_path / "flight"
    folder.mkdir()
    split = read_index(bag).chunks[0].start + 1_500_000_000
    rewritten(bag, folder / "flight_0.mcap", lambda _, message: message.log_time < split)
    rewritten(bag, folder / "flight_1.mcap", lambda _, message: message.log_time >= split)
    (folder / "metadata.yaml").touch()
    return folder


def test_a_folder_that_a_recorder_split_is_one_flight(folder, bag):
    whole, parts = RecordedSource(bag), RecordedSource(folder)
    assert (parts.clock.begin, parts.clock.end) == (whole.clock.begin, whole.clock.end)
    for time in (1.0, 1.5, 1.52, 3.0):
        ours, theirs = (source.flights()[0].at(time) for source in (whole, parts))
        np.testing.assert_array_equal(ours.position, theirs.position)
        np.testing.assert_array_equal(ours.plan, theirs.plan)
        assert (ours.time, ours.statuses) == (theirs.time, theirs.statuses)
        assert ours.errors == theirs.errors
    parts.close()


def test_a_folder_with_one_file_is_its_bag(tmp_path, bag):
    (tmp_path / "mission.mcap").write_bytes(bag.read_bytes())
    flown = load_configuration("small_uav", ["nmpc_controller.range=333.0"]).controller
    header = json.dumps({"version": "1", "parameters": asdict(flown)})
    (tmp_path / "controller.jsonl").write_text(f"{header}\n")
    assert RecordedSource(tmp_path).flights()[0].tracking == flown


def test_folders_that_are_no_bag_are_refused_in_words(tmp_path, folder):
    with pytest.raises(BagError, match=r"holds no bag: no file ends in \.mcap"):
        RecordedSource(tmp_path)
    (folder / "metadata.yaml").unlink()
    with pytest.raises(BagError, match=r"has no metadata\.yaml and 2 bags: name one of them"):
        RecordedSource(folder)


def test_a_replay_begins_at_the_first_command(tmp_path, bag):
    """Before it an aircraft may have waited long; the slider goes there all the same."""
    late = read_index(bag).chunks[0].start + 2_000_000_000

    def keep(channel, message):
        return channel.topic != "/uav/command" or message.log_time >= late

    source = RecordedSource(rewritten(bag, tmp_path / "late.mcap", keep))
    source.clock.pause()
    assert source.clock.begin < -1.5
    assert source.clock.time == pytest.approx(0.0, abs=0.5)
    source.clock.seek(-1.0)
    assert source.flights()[0].sight.mode is None


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
