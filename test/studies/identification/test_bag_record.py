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

"""A record from a bag, written as ``fly`` writes it."""

import numpy as np
import pytest
from rclpy.serialization import serialize_message

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes import topics
from uav_tracking_mpc.nodes.conversions import (
    set_air_velocity,
    set_command,
    set_odometry,
    set_stamp,
)
from uav_tracking_mpc.nodes.flight_bag import FlightBag
from uav_tracking_mpc.studies.identification import bag_record
from uav_tracking_mpc.studies.identification.bag_record import read_bag_record
from uav_tracking_mpc.studies.identification.flight_record import RecordError

TICK = 50_000_000  # ns
EPOCH = 1_700_000_000_000_000_000  # ns
PLAN = np.array([[0.1, 0.02, -0.3], [0.2, 0.03, 0.4]])
RATES = np.array([0.1, 0.05, 0.0])


def state(k):
    return np.array([200.0, 3.0 * k, 50.0, 0.01 * k, 0.05, 20.0 + 0.1 * k])


def write(path, count=20, clock=None, command=True, heard=2_000_000):
    """A flight at 20 Hz whose commands are heard 2 ms after the state that they answer."""
    bag = FlightBag(path)
    origin = EPOCH if clock is None else 0
    for k in range(count):
        stamp, wall = origin + k * TICK, EPOCH + k * TICK
        if clock is not None:
            message = topics.CLOCK.type()
            set_stamp(message.clock, stamp)
            bag.write(topics.CLOCK, wall, serialize_message(message))
        message = topics.ODOMETRY.type()
        set_odometry(message, stamp, state(k), RATES, velocity(state(k)))
        bag.write(topics.ODOMETRY, wall + 1, serialize_message(message))
        message = topics.AIR_VELOCITY.type()
        set_air_velocity(message, stamp, state(k)[5])
        bag.write(topics.AIR_VELOCITY, wall + 2, serialize_message(message))
        if command:
            message = topics.COMMAND.type()
            set_command(message, stamp, PLAN * (1.0 + k), 0.4)
            bag.write(topics.COMMAND, wall + heard, serialize_message(message))
    bag.close()
    return path


def test_states_are_those_that_were_sent(tmp_path):
    record = read_bag_record(write(tmp_path / "flight.mcap"))
    states = np.array([state(k) for k in range(20)])
    for found, column in ((record.heading, 3), (record.path_angle, 4), (record.airspeed, 5)):
        np.testing.assert_allclose(found.time, 0.05 * np.arange(20), atol=1e-9)
        np.testing.assert_allclose(found.value, states[:, column], atol=1e-9)
    np.testing.assert_allclose(record.turn_rate.value, RATES[0], atol=1e-9)
    np.testing.assert_allclose(record.path_angle_rate.value, RATES[1], atol=1e-9)


def test_a_command_counts_from_when_it_was_heard(tmp_path):
    record = read_bag_record(write(tmp_path / "flight.mcap"))
    np.testing.assert_allclose(record.demand.time[:20], 0.05 * np.arange(20) + 0.002, atol=1e-9)
    np.testing.assert_allclose(record.demand.inputs[3], 4.0 * PLAN[0], atol=1e-12)
    # The last plan is flown to its end.
    np.testing.assert_allclose(record.demand.inputs[-1], 20.0 * PLAN[1], atol=1e-12)


def test_simulated_time_stands_still_between_its_ticks(tmp_path):
    """However long the answer took by the clock on the wall."""
    record = read_bag_record(write(tmp_path / "flight.mcap", clock=True, heard=30_000_000))
    np.testing.assert_allclose(record.demand.time[:20], 0.05 * np.arange(20), atol=1e-9)


def test_a_bag_with_another_clock_is_refused(tmp_path):
    with pytest.raises(RecordError, match="do not share a clock"):
        read_bag_record(write(tmp_path / "flight.mcap", heard=60_000_000_000))


@pytest.mark.parametrize(
    ("options", "words"), [({"command": False}, "uav/command"), ({"count": 0}, "uav/odometry")]
)
def test_a_bag_that_lacks_something_is_refused(tmp_path, options, words):
    with pytest.raises(RecordError, match=f"holds no {words}"):
        read_bag_record(write(tmp_path / "flight.mcap", **options))


def test_what_is_no_bag_is_refused(tmp_path):
    path = tmp_path / "flight.mcap"
    path.write_bytes(b"nothing")
    with pytest.raises(RecordError, match="cannot be read as a bag"):
        read_bag_record(path)


def test_topics_are_those_that_fly():
    """Written down twice: reading a bag needs no ROS."""
    assert topics.ODOMETRY.name == bag_record.ODOMETRY
    assert topics.AIR_VELOCITY.name == bag_record.AIR_VELOCITY
    assert topics.COMMAND.name == bag_record.COMMAND
    assert f"/{bag_record.CLOCK}" == topics.CLOCK.name
