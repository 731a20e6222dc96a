import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.conversions import nanoseconds, plan_from_command, set_command
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
