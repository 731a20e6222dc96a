import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes import command_wire
from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    nanoseconds,
    plan_from_command,
    set_command,
)
from uav_tracking_mpc.nodes.topics import COMMAND


@settings(deadline=None, max_examples=60)
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
        message = COMMAND.type()
        set_command(message, stamp, inputs, step)
        written = wire.write(stamp, inputs, step)
        assert len(written) == len(serialize_message(message))
        assert deserialize_message(written, COMMAND.type) == message


def test_one_wire_takes_plans_of_any_form():
    wire = CommandWire()
    generator = np.random.default_rng(0)
    for count, step in ((20, 0.5), (1, 1.0), (7, 0.5), (20, 0.5)):
        plan = generator.normal(size=(count, 3))
        message = deserialize_message(wire.write(5_000_000_007, plan, step), COMMAND.type)
        assert nanoseconds(message.header.stamp) == 5_000_000_007
        heard, starts = plan_from_command(message)
        np.testing.assert_array_equal(heard, plan)
        assert starts == pytest.approx(step * np.arange(count))


def serialized(stamp, plan, step, change=lambda message: None):
    message = COMMAND.type()
    set_command(message, stamp, plan, step)
    change(message)
    return serialize_message(message)


def test_commands_are_read_as_they_were_written():
    wire, rng = CommandWire(), np.random.default_rng(1)
    for count, step in ((22, 0.4), (22, 0.4), (22, 0.1), (1, 1.0), (1, 1.0), (22, 0.4)):
        plan, stamp = rng.normal(size=(count, 3)), int(rng.integers(0, 2**60))
        for data in (serialized(stamp, plan, step), CommandWire().write(stamp, plan, step)):
            got, read, seconds = wire.read(data)
            assert got == stamp
            np.testing.assert_array_equal(read, plan)
            assert seconds == pytest.approx(step)


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
def test_what_is_no_command_is_refused_before_and_after_a_good_one(change, words):
    wire, plan = CommandWire(), np.ones((4, 3))
    bad = serialized(1, plan, 0.4, change)
    for _ in range(2):
        with pytest.raises(MessageError, match=words):
            wire.read(bad)
        assert wire.read(serialized(2, plan, 0.4))[0] == 2


def test_a_command_with_more_in_it_is_read_all_the_same():
    wire, plan = CommandWire(), np.ones((4, 3))
    wire.read(serialized(1, plan, 0.4))

    def add(message):
        message.points[0].velocities[0].linear.x = 9.0

    more = serialized(2, 2.0 * plan, 0.4, add)
    np.testing.assert_array_equal(wire.read(more)[1], 2.0 * plan)


@pytest.mark.parametrize("data", [b"", b"banana", serialized(1, np.ones((4, 3)), 0.4)[:-40]])
def test_bytes_that_are_no_message_are_refused(data):
    wire = CommandWire()
    wire.read(serialized(1, np.ones((4, 3)), 0.4))
    with pytest.raises(MessageError):
        wire.read(data)


def test_what_differs_in_numbers_alone_is_not_turned_into_objects(monkeypatch):
    wire, sender = CommandWire(), CommandWire()
    wire.read(sender.write(1, np.ones((22, 3)), 0.4))
    monkeypatch.setattr(command_wire, "deserialize_message", None)
    stamp, plan, step = wire.read(sender.write(2, np.full((22, 3), 0.5), 0.4))
    assert (stamp, step) == (2, 0.4)
    np.testing.assert_array_equal(plan, np.full((22, 3), 0.5))
