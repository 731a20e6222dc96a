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

"""The orbit that is flown goes through a message unchanged, and what is none is refused."""

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.nodes.conversions import nanoseconds
from uav_tracking_mpc.nodes.message_checks import MessageError
from uav_tracking_mpc.nodes.orbit_message import orbit_from_message, orbit_message, set_orbit

ORBIT = FlownOrbit(np.array([1.0, -2.0, 130.0]), np.array([5.0, 0.5, 0.0]), -275.0, 22.0)
STAMP = 12_345_678_901


def message(orbit=ORBIT):
    filled = orbit_message()
    set_orbit(filled, STAMP, orbit)
    return deserialize_message(serialize_message(filled), JointState)


def test_an_orbit_comes_back():
    got = message()
    back = orbit_from_message(got)
    np.testing.assert_array_equal(back.centre, ORBIT.centre)
    np.testing.assert_array_equal(back.velocity, ORBIT.velocity)
    assert back[2:] == ORBIT[2:]
    assert nanoseconds(got.header.stamp) == STAMP
    assert list(got.name) == ["east", "north", "up", "radius", "airspeed"]


def test_a_message_is_filled_again():
    filled = orbit_message()
    set_orbit(filled, 1, ORBIT)
    set_orbit(filled, 2, ORBIT._replace(radius=100.0))
    assert orbit_from_message(filled).radius == 100.0
    assert orbit_message().position[3] == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: setattr(m.header, "frame_id", "odom"), "header.frame_id is 'odom'"),
        (lambda m: setattr(m, "name", ["east"]), "name is"),
        (lambda m: setattr(m, "position", [0.0] * 4), "position is"),
        (lambda m: setattr(m, "velocity", []), "velocity is"),
        (lambda m: m.position.__setitem__(0, float("nan")), "position is"),
        (lambda m: m.velocity.__setitem__(2, float("inf")), "velocity is"),
        (lambda m: m.position.__setitem__(4, 1e4), "position is"),
    ],
)
def test_what_is_no_orbit_is_refused(change, words):
    bad = message()
    change(bad)
    with pytest.raises(MessageError, match=words):
        orbit_from_message(bad)
