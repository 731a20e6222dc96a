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

"""The aircraft of a bag, found by their topics, as they are seen at a time of the record."""

import json
import resource
from dataclasses import asdict
from time import perf_counter, process_time

import numpy as np
import pytest
from processes import scripted
from recorded_bag import (
    COMMAND_DELAY,
    ORBIT_WANTED,
    SECOND,
    STAGES,
    STD,
    STEP,
    TARGET_STD,
    TARGET_VELOCITY,
    WIND,
    SyntheticFlight,
    lengthen,
    rewritten,
    write_bag,
)

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, ODOMETRY, TARGET
from uav_tracking_mpc.report import bag_index as bags
from uav_tracking_mpc.report.bag import BagError
from uav_tracking_mpc.report.bag_index import KEPT, Bag, BagTopic
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.recorded_source import RecordedSource, RecordedTime
from uav_tracking_mpc.view.watched_flight import SILENT

RATES = {"state_rate": 20, "command_rate": 10}


def opened(path):
    bag = Bag(path)
    states, commands = (BagTopic(bag, name) for name in ("/uav/odometry", "/uav/command"))
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
    original = bags.header_stamp
    monkeypatch.setattr(
        bags, "header_stamp", lambda data: original(data) % (2 * SECOND) if stamp is None else stamp
    )
    states, time = opened(path)
    assert time.clock.end - time.clock.begin == pytest.approx(2.0)
    at = time.seconds(time.moment(states, time.newest(states, 1.0)))
    assert 1.0 - 0.025 < at <= 1.0


PERIOD = 0.05  # s between states
FALLBACK, SILENCE = (4.0, 6.0), (8.0, 20.0)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A simulation at half of real time, so that silence lasts."""
    folder = tmp_path_factory.mktemp("bag")
    write_bag(
        folder / "flight.mcap",
        30.0,
        state_rate=20,
        command_rate=10,
        speed=0.5,
        fallbacks=[FALLBACK],
        silence=[SILENCE],
    )
    path = rewritten(folder / "flight.mcap", folder / "small.mcap", chunk_size=50_000)
    source = RecordedSource(path)
    source.clock.pause()
    yield source
    source.close()


def seen(source, time):
    source.clock.seek(time)
    (flight,) = source.flights()
    return flight.sight


@pytest.mark.parametrize("time", [29.0, 0.0, 3.0, 3.01, 17.77, 30.0])
def test_a_replay_stands_at_the_time_of_its_clock(source, time):
    sight = seen(source, time)
    assert time - PERIOD < sight.time <= time


def test_the_aircraft_is_where_it_was(source):
    sight, flown = seen(source, 3.0), SyntheticFlight()
    np.testing.assert_allclose(sight.position, flown.vehicle(3.0)[:3], atol=1e-9)
    np.testing.assert_allclose(sight.ground_velocity, flown.ground_velocity(3.0), atol=1e-9)
    np.testing.assert_allclose(sight.wind, WIND, atol=1e-9)
    assert sight.airspeed == pytest.approx(ORBIT_WANTED.speed)
    assert np.remainder(sight.heading - flown.vehicle(3.0)[3], 2.0 * np.pi) == pytest.approx(0.0)
    assert sight.bank == pytest.approx(bank_from_turn_rate(flown.turn_rate, ORBIT_WANTED.speed))


def test_target_and_orbits_are_what_the_controller_took_them_for(source):
    sight, target = seen(source, 3.0), SyntheticFlight().target(3.0)
    np.testing.assert_allclose(sight.target.truth, target, atol=1e-9)
    np.testing.assert_allclose(sight.target.position, target, atol=1e-9)
    assert sight.target.std == TARGET_STD
    np.testing.assert_allclose(sight.target.velocity, TARGET_VELOCITY)
    assert 0.0 < np.linalg.norm(sight.target.measured - target) < 8.0 * STD
    assert sight.flown.radius == pytest.approx(ORBIT_WANTED.radius)
    assert sight.wanted.radius == pytest.approx(ORBIT_WANTED.radius)
    np.testing.assert_allclose(sight.wanted.centre[:2], target[:2], atol=1e-9)


def test_the_plan_begins_at_the_aircraft(source):
    sight, flown = seen(source, 3.0), SyntheticFlight()
    expected = [flown.vehicle(3.0 + k * STEP)[:3] for k in range(STAGES)]
    np.testing.assert_allclose(sight.plan, expected, atol=1e-9)


def test_figures_of_the_controller(source):
    sight = seen(source, 3.0)
    assert set(sight.errors) == {
        "range_error", "bearing_error", "altitude_error", "pitch_error", "speed_error",
    }  # fmt: skip
    assert sight.cost == pytest.approx(4.0, abs=0.11)
    assert sight.solve_time == pytest.approx(1e-3)
    assert sight.latency == pytest.approx(COMMAND_DELAY * 1e-9)


@pytest.mark.parametrize(
    ("time", "mode", "reason"),
    [
        (3.0, FallbackMode.OPTIMAL, ""),
        (5.0, FallbackMode.LOITER, "target position is lost"),
        (7.0, FallbackMode.OPTIMAL, ""),
        (12.0, FallbackMode.SILENCE, "nothing comes on uav/command for 4 s"),
        (22.0, FallbackMode.OPTIMAL, ""),
    ],
)
def test_the_mode_and_its_reason(source, time, mode, reason):
    sight = seen(source, time)
    assert (sight.mode, sight.reason) == (mode, reason)


def test_without_a_controller_nothing_of_it_is_shown(source):
    sight = seen(source, 12.0)
    assert sight.plan is None
    assert sight.flown is None
    assert not sight.errors
    assert sight.target.measured is not None


def test_a_node_that_reports_no_more_is_silent(source):
    before, after = (
        {status.node: status.level for status in seen(source, time).statuses}
        for time in (7.5, 19.5)
    )
    assert before["nmpc_controller"] == 0
    assert after["nmpc_controller"] == SILENT
    assert after["uav_simulator"] == 0


def test_the_past_is_what_was_seen_then(source):
    sight = seen(source, 10.0)
    (flight,) = source.flights()
    past = flight.past(4.0)
    times = [each.time for each in past]
    assert times == sorted(set(times))
    assert 6.0 - PERIOD <= times[0] <= 6.3
    assert sight.time - 0.3 <= times[-1] <= sight.time
    assert max(np.diff(times)) < 0.3
    for each in past:
        then = flight.at(each.time)
        np.testing.assert_array_equal(each.position, then.position)
        assert (each.mode, each.reason, each.errors) == (then.mode, then.reason, then.errors)


def test_the_past_after_a_jump_is_that_of_the_new_time(source):
    (flight,) = source.flights()
    for time in (28.0, 9.0, 25.0):
        source.clock.seek(time)
        times = [each.time for each in flight.past(5.0)]
        assert all(time - 5.0 - PERIOD <= each <= time for each in times)
        assert len(times) >= 20


def test_states_alone_are_enough(tmp_path):
    path = tmp_path / "states.mcap"
    write_bag(path, 2.0, state_rate=20, command_rate=10, topics=(ODOMETRY,))
    sight = seen(RecordedSource(path), 1.0)
    assert (sight.target, sight.wanted, sight.flown, sight.plan, sight.mode) == (None,) * 5
    assert np.isnan([sight.airspeed, sight.cost, sight.solve_time, sight.latency]).all()
    assert sight.wind is None


def test_two_minutes_are_followed_from_end_to_end(tmp_path):
    """At the full rates, with the chunks of the real writer."""
    write_bag(tmp_path / "short.mcap", 10.0)
    lengthen(tmp_path / "short.mcap", tmp_path / "flight.mcap", 12)
    source = RecordedSource(tmp_path / "flight.mcap")
    assert source.clock.end == pytest.approx(120.2, abs=0.1)
    (flight,) = source.flights()
    for time in np.arange(0.0, source.clock.end, 7.3):
        sight = flight.at(time)
        assert time - 0.021 < sight.time <= time
        assert sight.mode is FallbackMode.OPTIMAL
        assert sight.errors
        assert sight.plan is not None
    source.clock.seek(120.0)
    assert len(flight.past(120.0)) == pytest.approx(600, abs=3)
    source.close()


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


@pytest.fixture
def folder(tmp_path, bag):
    """As `ros2 bag record` splits it, after 1.5 s."""
    folder = tmp_path / "flight"
    folder.mkdir()
    split = Bag(bag).chunks[0].index.message_start_time + 1_500_000_000
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


def test_folders_that_are_no_bag_are_refused_in_words(tmp_path, folder):
    with pytest.raises(BagError, match=r"holds no bag: no file ends in \.mcap"):
        RecordedSource(tmp_path)
    (folder / "metadata.yaml").unlink()
    with pytest.raises(BagError, match=r"has no metadata\.yaml and 2 bags: name one of them"):
        RecordedSource(folder)


def test_a_replay_begins_at_the_first_command(tmp_path, bag):
    """Before it an aircraft may have waited long; the slider goes there all the same."""
    late = Bag(bag).chunks[0].index.message_start_time + 2_000_000_000

    def keep(channel, message):
        return channel.topic != "/uav/command" or message.log_time >= late

    source = RecordedSource(rewritten(bag, tmp_path / "late.mcap", keep))
    source.clock.pause()
    assert source.clock.begin < -1.5
    assert source.clock.time == pytest.approx(0.0, abs=0.5)
    source.clock.seek(-1.0)
    assert source.flights()[0].sight.mode is None


@pytest.mark.parametrize(
    ("topics", "words"),
    [
        ((TARGET, AIR_VELOCITY), r"holds no aircraft.*uav/odometry.*/target/position"),
        ((), "holds no message"),
    ],
)
def test_a_bag_without_an_aircraft_is_refused(tmp_path, topics, words):
    path = tmp_path / "other.mcap"
    write_bag(path, 1.0, **RATES, topics=topics)
    with pytest.raises(BagError, match=words) as no:
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
    for place in (path, tmp_path):  # a folder with one file is its bag
        assert RecordedSource(place).flights()[0].tracking == flown
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
from pathlib import Path
from uav_tracking_mpc.view.recorded_source import RecordedSource
sight = RecordedSource(Path(sys.argv[1])).flights()[0].at(2.0)
print(sight.time, sight.mode.value, len(sight.plan), len(sight.statuses), sorted(sight.errors)[0])
"""


def test_a_bag_is_shown_without_ros(bag):
    missing = [
        "rclpy", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs",
        "rcl_interfaces", "rosgraph_msgs", "sensor_msgs", "std_msgs", "trajectory_msgs",
        "visualization_msgs",
    ]  # fmt: skip
    code, output, errors = scripted(WITHOUT_ROS, bag, missing=missing)
    assert (code, output) == (0, "2.0 optimal plan 20 3 altitude_error\n"), errors


HOURS = 2.0
JUMPS = (6543.2, 17.0, 3600.0, 5000.0, 1234.5, 7199.0)  # s
OPENED, JUMPED = 40, 90  # chunks: samples and ends; two minutes of a track and what leads to it


@pytest.fixture
def unpacked(monkeypatch):
    """Numbers of the chunks that were unpacked."""
    numbers, unpack = [], Bag._unpack

    def noted(self, number):
        numbers.append(number)
        return unpack(self, number)

    monkeypatch.setattr(Bag, "_unpack", noted)
    return numbers


def measured(words, function):
    wall, cpu = perf_counter(), process_time()
    result = function()
    wall, cpu = perf_counter() - wall, process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{words}: {wall:.2f} s, {cpu:.2f} s of CPU, at most {memory:.0f} MB so far")
    return result


@pytest.mark.long
def test_two_hours_take_a_few_chunks(tmp_path, unpacked):
    write_bag(tmp_path / "short.mcap", 120.0)
    path = tmp_path / "long.mcap"
    lengthen(tmp_path / "short.mcap", path, round(HOURS * 30))
    print(f"\n{path.stat().st_size / 1e6:.0f} MB for {HOURS:g} hours")
    source = measured("open", lambda: RecordedSource(path))
    assert source.clock.end >= HOURS * 3600.0
    assert len(source._bag.chunks) > 1000
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
        largest = max(chunk.index.uncompressed_size for chunk in source._bag.chunks)
        assert source._bag.unpacked.cache_info().currsize * largest <= KEPT
    source.close()
