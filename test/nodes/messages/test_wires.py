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

"""Commands as bytes are the messages that the middleware makes of them."""

import numpy as np
import pytest
from filled_messages import filled_command
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.dynamics.frames import quaternion_from_course
from uav_tracking_mpc.nodes.messages.conversions import plan_from_command
from uav_tracking_mpc.nodes.messages.wires import (
    CommandWire,
    OdometryWire,
    command_segments,
    deserialized,
    even_command,
    planned_places,
)
from uav_tracking_mpc.nodes.topics import (
    ANY_FRAMES,
    COMMAND,
    FRAMES,
    ODOMETRY,
    FrameNames,
    MessageError,
)


@given(
    st.lists(st.tuples(*[st.floats(-10.0, 10.0)] * 3), min_size=1, max_size=30),
    st.integers(0, 2**62 // 4),
    st.sampled_from([0.02, 0.4, 1.0]),
)
def test_bytes_read_as_the_message(plan, stamp, step):
    """Not byte by byte: CDR leaves what stands between aligned fields undefined."""
    wire = CommandWire()
    for shift in (0.0, 0.25):  # written anew, then in place
        inputs = np.array(plan) + shift
        message = filled_command(stamp, inputs, step)
        written = wire.write(stamp, inputs, step)
        assert len(written) == len(serialize_message(message))
        assert deserialize_message(written, COMMAND.type) == message


def path_of(plan):
    """A path for a plan, all of whose numbers differ."""
    random = np.random.default_rng(len(plan))
    states = random.normal(size=(len(plan) + 1, 6))
    return PlannedPath(states, random.normal(size=(len(plan) + 1, 3)))


def test_each_point_carries_its_place_its_attitude_and_its_velocity():
    wire, generator = CommandWire(), np.random.default_rng(3)
    for count, step in ((20, 0.5), (20, 0.5), (1, 1.0), (7, 0.5)):  # anew, in place, other forms
        plan = generator.normal(size=(count, 3))
        path = path_of(plan)
        message = deserialize_message(wire.write(1, plan, step, path), COMMAND.type)
        for point, state, ground in zip(
            message.points, path.states, path.ground_velocities, strict=False
        ):
            (transform,), (velocity,) = point.transforms, point.velocities
            place, q, linear = transform.translation, transform.rotation, velocity.linear
            np.testing.assert_array_equal([place.x, place.y, place.z], state[:3])
            expected = quaternion_from_course(state[3], state[4])
            assert (q.x, q.y, q.z, q.w) == pytest.approx(expected, abs=1e-15)
            np.testing.assert_array_equal([linear.x, linear.y, linear.z], ground)
        heard, _ = plan_from_command(message)
        np.testing.assert_array_equal(heard, plan)


def serialized(stamp, plan, step, change=lambda message: None):
    message = filled_command(stamp, plan, step)
    change(message)
    return serialize_message(message)


@pytest.mark.parametrize("count", [1, 22])
def test_commands_are_read_as_they_were_written_with_a_path_or_without(count):
    """A controller of somebody else need not send any."""
    plan = np.random.default_rng(1).normal(size=(count, 3))
    sent = (
        serialized(2**60, plan, 0.4),
        CommandWire().write(2**60, plan, 0.4),
        CommandWire().write(2**60, plan, 0.4, path_of(plan)),
    )
    for data in sent:
        stamp, read, step = even_command(data)
        assert (stamp, step) == (2**60, 0.4 if count > 1 else 1.0)
        np.testing.assert_array_equal(read, plan)


def test_segments_need_not_be_of_one_length():
    plan = np.ones((3, 3))
    uneven = serialized(7, plan, 0.4, lambda m: setattr(m.points[2].time_from_start, "sec", 5))
    stamp, read, starts = command_segments(uneven)
    assert stamp == 7
    np.testing.assert_array_equal(read, plan)
    assert starts == pytest.approx([0.0, 0.4, 5.8])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: setattr(m.header, "frame_id", "odo"), "header.frame_id is 'odo'"),
        (lambda m: setattr(m.header.stamp, "nanosec", 2_000_000_000), "nanosec is 2000000000"),
        (lambda m: setattr(m, "joint_names", ["link_base"]), "joint_names is"),
        (lambda m: setattr(m.points[2].velocities[0].angular, "z", np.nan), "must be finite"),
        (lambda m: setattr(m.points[2].time_from_start, "sec", 7), "not of one length"),
        (lambda m: m.points[1].velocities.clear(), "lacks velocities"),
        (lambda m: m.points.clear(), "points is empty"),
    ],
)
def test_what_is_no_command_is_refused(change, words):
    with pytest.raises(MessageError, match=words):
        even_command(serialized(1, np.ones((4, 3)), 0.4, change))


@pytest.mark.parametrize("data", [b"", b"banana", serialized(1, np.ones((4, 3)), 0.4)[:-40]])
def test_bytes_that_are_no_message_are_refused(data):
    with pytest.raises(MessageError, match="uav/command: no message"):
        even_command(data)


@pytest.mark.parametrize("named", [FRAMES, FrameNames("world", "red/base_link")])
def test_the_planned_places_are_read_whatever_the_frames(named):
    writing = CommandWire(named)
    for count in (5, 5, 1):
        path = path_of(np.zeros((count, 3)))
        data = writing.write(3_000_000_001, np.zeros((count, 3)), 0.5, path)
        stamp, positions, times = planned_places(data, ANY_FRAMES)
        assert stamp == 3_000_000_001
        np.testing.assert_array_equal(positions, path.states[:-1, :3])
        assert times == pytest.approx(0.5 * np.arange(count))
    _, positions, times = planned_places(writing.write(1, np.zeros((5, 3)), 0.5), ANY_FRAMES)
    assert positions.shape == (0, 3) and times.shape == (0,)


def test_a_planned_place_that_is_none_is_refused():
    path = path_of(np.zeros((5, 3)))
    path.states[2, 1] = np.nan
    with pytest.raises(MessageError, match="transforms.y is nan"):
        planned_places(CommandWire().write(1, np.zeros((5, 3)), 0.5, path))


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + b"\xff" * 60])
def test_what_is_no_message_is_refused_in_words(data):
    with pytest.raises(MessageError, match="uav/odometry: no message"):
        deserialized(ODOMETRY, data)
    assert deserialized(ODOMETRY, serialize_message(ODOMETRY.type())) == ODOMETRY.type()


def odometry(stamp, numbers, frame="map", child="base_link"):
    message = ODOMETRY.type()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    message.header.frame_id, message.child_frame_id = frame, child
    place, attitude = message.pose.pose.position, message.pose.pose.orientation
    place.x, place.y, place.z, attitude.x, attitude.y, attitude.z, attitude.w = numbers[:7]
    message.pose.covariance[:], message.twist.covariance[:] = numbers[7:43], numbers[49:]
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = numbers[43:49]
    return message


def told(message):
    """All of a state, numbers to the last bit; between texts the middleware leaves any bytes."""
    place, attitude = message.pose.pose.position, message.pose.pose.orientation
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    numbers = [place.x, place.y, place.z, attitude.x, attitude.y, attitude.z, attitude.w]
    numbers += [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    numbers += [*message.pose.covariance, *message.twist.covariance]
    header = message.header
    texts = header.frame_id, message.child_frame_id
    return header.stamp.sec, header.stamp.nanosec, *texts, np.array(numbers).tobytes()


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2**31 * 10**9 - 1),
            st.lists(st.floats(), min_size=85, max_size=85),
            st.sampled_from(["map", "", "odometry", "k\u00e4rte"]),
            st.sampled_from(["base_link", "uav1/base_link", "a"]),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_a_state_is_read_as_the_middleware_reads_it(messages):
    wire = OdometryWire()
    for stamp, numbers, *frames in messages:
        data = bytes(serialize_message(odometry(stamp, numbers, *frames)))
        for read in (wire.read(data), wire.read(data)):  # the second one in place
            assert told(read) == told(deserialize_message(data, ODOMETRY.type))


def test_a_state_whose_numbers_are_not_its_end_is_read_by_the_middleware():
    wire, data = (
        OdometryWire(),
        bytes(serialize_message(odometry(1, [float(k) for k in range(85)]))),
    )
    for _ in range(2):
        assert wire.read(data + bytes(8)).twist.covariance[-1] == 84.0


def test_what_is_no_state_is_refused_and_the_next_one_read():
    wire, data = OdometryWire(), bytes(serialize_message(odometry(1, [1.0] * 85)))
    for _ in range(2):
        assert wire.read(data).pose.pose.position.x == 1.0
        for broken in (b"", data[:3], data[:12], data[:-8]):
            with pytest.raises(MessageError, match="uav/odometry: no message"):
                wire.read(broken)
