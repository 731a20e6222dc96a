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

"""A record comes back from its CSV file as it was."""

import dataclasses

import numpy as np
import pytest
from filled_messages import (
    filled_air,
    filled_clock,
    filled_command,
    filled_odometry,
    write_messages,
)

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.identification.flight_record import (
    FlightRecord,
    FlightWitness,
    FlownPlan,
    Samples,
    flown_demand,
    read_bag_record,
    read_csv_record,
    samples,
    write_record,
)

MINIMAL = "time,turn_command,path_command,acceleration_command,heading,path_angle\n"


@pytest.fixture(scope="module")
def flown():
    """10 s with a law, which needs no solver; the state comes 0.15 s late."""
    overrides = ["mission.duration=10", "nmpc_controller.law=l1", "uav_simulator.state_delay=0.15"]
    witness = FlightWitness()
    simulate(load_configuration("small_uav", overrides), witness=witness)
    return witness.record()


def test_it_comes_back_bit_for_bit(flown, tmp_path):
    write_record(flown, tmp_path / "out" / "record.csv")
    again = read_csv_record(tmp_path / "out" / "record.csv")
    for field in dataclasses.fields(flown):
        before, after = getattr(flown, field.name), getattr(again, field.name)
        for one, other in zip(before, after, strict=True):
            np.testing.assert_array_equal(one, other)


def test_commands_count_from_when_they_are_given_and_states_from_when_they_were(flown):
    assert flown.heading.time[-1] == pytest.approx(flown.demand.time[-1] - 0.15, abs=0.051)


def test_columns_that_may_be_missing_and_cells_that_may_be_empty(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text(MINIMAL + "0.0,0.1,0.2,0.3,,\n0.01,,,,1.0,0.5\n0.05,0.2,0.2,0.3,1.1,0.5\n")
    record = read_csv_record(path)
    np.testing.assert_array_equal(record.demand.value, [[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]])
    np.testing.assert_array_equal(record.heading.time, [0.01, 0.05])
    assert record.airspeed is None and record.turn_rate is None


def test_of_a_record_with_a_gap_the_longest_stretch_is_used_whatever_stands_beside_it(tmp_path):
    path = tmp_path / "flight.csv"
    rows = [f"{t / 10},{t},0,0,0,0,Bö" for t in (*range(30), *range(100, 150), *range(300, 310))]
    path.write_text("\n".join([MINIMAL.strip() + ",note", *rows[::-1]]), encoding="latin-1")
    record = read_csv_record(path)
    for known in (record.demand.time, record.heading.time):
        np.testing.assert_allclose(known, np.arange(10.0, 14.99, 0.1))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,heading\n0,1\n", "has no columns turn_command, path_command"),
        (MINIMAL + "0,1,2,x,0,0\n", "line 2: acceleration_command is 'x', must be a number"),
        (MINIMAL + "0,,,,0,0\n", "holds no command"),
        (MINIMAL + "0,0,0,0,0,2\n", "path_angle is beyond \\+-90 deg, must be in rad"),
    ],
)
def test_what_is_no_record_is_refused(tmp_path, text, words):
    path = tmp_path / "flight.csv"
    path.write_text(text)
    with pytest.raises(ParameterError, match=words):
        read_csv_record(path)


TICK = 50_000_000  # ns
EPOCH = 1_700_000_000_000_000_000  # ns
PLAN = np.array([[0.1, 0.02, -0.3], [0.2, 0.03, 0.4]])
RATES = np.array([0.1, 0.05, 0.0])


def state(k):
    return np.array([200.0, 3.0 * k, 50.0, 0.01 * k, 0.05, 20.0 + 0.1 * k])


def write(path, count=20, clock=None, command=True, heard=2_000_000):
    """A flight at 20 Hz whose commands are heard 2 ms after the state that they answer."""

    def said():
        for k in range(count):
            wall = EPOCH + k * TICK
            stamp = wall if clock is None else k * TICK
            if clock is not None:
                yield CLOCK, wall, filled_clock(stamp)
            yield ODOMETRY, wall + 1, filled_odometry(stamp, state(k), RATES, velocity(state(k)))
            yield AIR_VELOCITY, wall + 2, filled_air(stamp, state(k)[5])
            if command:
                yield COMMAND, wall + heard, filled_command(stamp, PLAN * (1.0 + k), 0.4)

    return write_messages(path, said())


def test_states_count_from_their_stamps_and_a_command_from_when_it_was_heard(tmp_path):
    record = read_bag_record(write(tmp_path / "flight.mcap"))
    states = np.array([state(k) for k in range(20)])
    for found, column in ((record.heading, 3), (record.path_angle, 4), (record.airspeed, 5)):
        np.testing.assert_allclose(found.time, 0.05 * np.arange(20), atol=1e-9)
        np.testing.assert_allclose(found.value, states[:, column], atol=1e-9)
    np.testing.assert_allclose(record.turn_rate.value, RATES[0], atol=1e-9)
    np.testing.assert_allclose(record.path_angle_rate.value, RATES[1], atol=1e-9)
    np.testing.assert_allclose(record.demand.time[:20], 0.05 * np.arange(20) + 0.002, atol=1e-9)
    np.testing.assert_allclose(record.demand.value[3], 4.0 * PLAN[0], atol=1e-12)
    # The last plan is flown to its end.
    np.testing.assert_allclose(record.demand.value[-1], 20.0 * PLAN[1], atol=1e-12)


def test_simulated_time_stands_still_between_its_ticks(tmp_path):
    """However long the answer took by the clock on the wall."""
    record = read_bag_record(write(tmp_path / "flight.mcap", clock=True, heard=30_000_000))
    np.testing.assert_allclose(record.demand.time[:20], 0.05 * np.arange(20), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"heard": 60_000_000_000}, "do not share a clock"),
        ({"command": False}, "holds no uav/command"),
        ({"count": 0}, "holds no uav/odometry"),
    ],
)
def test_a_bag_that_lacks_something_is_refused(tmp_path, options, words):
    with pytest.raises(ParameterError, match=words):
        read_bag_record(write(tmp_path / "flight.mcap", **options))


def test_what_is_no_bag_is_refused(tmp_path):
    path = tmp_path / "flight.mcap"
    path.write_bytes(b"nothing")
    with pytest.raises(ParameterError, match="cannot be read as a bag"):
        read_bag_record(path)


def plan(time, begin, values, step=0.4):
    inputs = np.column_stack([values, np.zeros(len(values)), np.zeros(len(values))])
    return FlownPlan(time, begin + step * np.arange(len(values)), inputs)


def test_a_plan_counts_from_when_it_came_to_when_the_next_one_does():
    """It is laid out from the stamp of the state that it answers: what is over is not flown."""
    demand = flown_demand([plan(0.1, 0.0, [1.0, 2.0, 3.0]), plan(0.9, 0.45, [4.0, 5.0, 6.0])])
    np.testing.assert_allclose(demand.time, [0.1, 0.4, 0.8, 0.9, 1.25])
    np.testing.assert_array_equal(demand.value[:, 0], [1.0, 2.0, 3.0, 5.0, 6.0])


def test_of_a_flight_with_a_gap_the_longer_part_is_used():
    before = [plan(0.4 * k, 0.4 * k, [1.0]) for k in range(3)]
    after = [plan(20.0 + 0.4 * k, 20.0 + 0.4 * k, [2.0]) for k in range(5)]
    assert set(flown_demand([*before, *after]).value[:, 0]) == {2.0}


def test_without_commands_there_is_nothing_to_identify():
    with pytest.raises(ParameterError, match="no commands"):
        flown_demand([])


def test_samples_are_put_in_order_and_doubles_and_gaps_left_out():
    kept = samples([2.0, 1.0, 1.0, 3.0], [20.0, 10.0, 11.0, np.nan])
    np.testing.assert_array_equal(kept.time, [1.0, 2.0])
    np.testing.assert_array_equal(kept.value, [10.0, 20.0])


def record(airspeed=True, rate=0.1):
    time = np.arange(0.0, 30.0, 0.05)
    inputs = np.tile([0.1, 0.0, 0.0], (len(time), 1))
    heading = (0.1 * time + np.pi) % (2.0 * np.pi) - np.pi
    return FlightRecord(
        Samples(time, inputs),
        samples(time, heading),
        samples(time, np.zeros_like(time)),
        samples(time, np.full_like(time, 20.0)) if airspeed else None,
        samples(time, rate + 0.001 * np.sin(time)),
        samples(time, np.zeros_like(time)),
    )


def test_heading_is_unwrapped_and_a_turn_banks_by_its_airspeed():
    turn, path, speed = record().channels()
    np.testing.assert_allclose(np.diff(turn.state.value), 0.005)
    np.testing.assert_allclose(turn.leverage, 20.0 / GRAVITY)
    assert (turn.name, path.name, speed.name) == ("turn", "path", "speed")
    # A rate that stands still is not measured.
    assert turn.rate is not None and path.rate is None


def test_without_airspeed_there_is_no_speed_channel():
    assert [channel.name for channel in record(airspeed=False).channels()] == ["turn", "path"]
