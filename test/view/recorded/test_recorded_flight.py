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

"""What there is to see of an aircraft at a time of the record is what its messages say."""

import numpy as np
import pytest
from recorded_bag import (
    COMMAND_DELAY,
    ORBIT_WANTED,
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
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.view.recorded.recorded_source import RecordedSource
from uav_tracking_mpc.view.recorded.recorded_statuses import SILENT

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
        (12.0, FallbackMode.SILENCE, "no command for 4.1 s"),
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
