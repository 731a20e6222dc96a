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

"""The orbit and what is tracked by, as figures by name."""

import math

import numpy as np
import pytest
import small_uav
from filled_messages import altered, filled_orbit, over_the_wire
from sensor_msgs.msg import JointState

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.messages.named_figures import (
    orbit_from_message,
    orbit_message,
    set_orbit,
    set_tracking,
    told_mode,
    tracking_figures,
    tracking_message,
)
from uav_tracking_mpc.nodes.topics import MessageError

ORBIT = FlownOrbit(np.array([1.0, -2.0, 130.0]), np.array([5.0, 0.5, 0.0]), -275.0, 22.0)
STAMP = 12_345_678_901


def message(orbit=ORBIT):
    return over_the_wire(filled_orbit(STAMP, orbit))


def test_an_orbit_comes_back():
    got = message()
    back = orbit_from_message(got)
    np.testing.assert_array_equal(back.centre, ORBIT.centre)
    np.testing.assert_array_equal(back.velocity, ORBIT.velocity)
    assert back[2:] == ORBIT[2:]
    assert nanoseconds(got.header.stamp) == STAMP
    assert list(got.name) == ["east", "north", "up", "radius", "airspeed"]


def test_a_message_is_filled_again():
    filled = filled_orbit(1, ORBIT)
    set_orbit(filled, 2, ORBIT._replace(radius=100.0))
    assert orbit_from_message(filled).radius == 100.0
    assert orbit_message().position[3] == 0.0


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("header.frame_id", "odom", "header.frame_id is 'odom'"),
        ("name", ["east"], "name is"),
        ("position", [0.0] * 4, "position is"),
        ("velocity", [], "velocity is"),
        ("position.0", math.nan, "position is"),
        ("velocity.2", math.inf, "velocity is"),
        ("position.4", 1e4, "position is"),
    ],
)
def test_what_is_no_orbit_is_refused(path, value, words):
    with pytest.raises(MessageError, match=words):
        orbit_from_message(altered(message(), path, value))


WANTED = small_uav.parameters().orbit
WIND = np.array([3.0, -4.0, 0.5])


def heard(situation, mode=FallbackMode.OPTIMAL):
    message = tracking_message()
    set_tracking(message, 5_000_000_007, situation, WANTED, 0.7, WIND, mode, 0.02)
    said = over_the_wire(message)
    assert nanoseconds(said.header.stamp) == 5_000_000_007
    assert said.header.frame_id == "map"
    assert not (said.velocity or said.effort)
    return said


def values(situation):
    return tracking_figures(heard(situation))


def test_each_error_has_its_name_and_its_sign():
    x = math.sqrt((WANTED.range + 10.0) ** 2 - (WANTED.altitude + 4.0) ** 2)
    now = small_uav.situation(x, 0.0, WANTED.altitude + 4.0, 1.0, 0.05, WANTED.speed + 2.0)
    told = values(now)
    assert told["range_error"] == pytest.approx(10.0)
    assert told["altitude_error"] == pytest.approx(4.0)
    assert told["pitch_error"] == 0.05
    assert told["speed_error"] == pytest.approx(2.0)
    heading, azimuth = math.atan2(*now.air_velocity[1::-1]), 0.0
    bearing = math.remainder(heading - azimuth - math.pi - WANTED.bearing, 2.0 * math.pi)
    assert told["bearing_error"] == pytest.approx(bearing)


def test_the_bank_is_that_of_a_coordinated_turn_right_wing_down():
    now = small_uav.situation(300.0, 0.0, 120.0, 1.6, 0.0, 22.0, rates=(-0.2, 0.0, 0.0))
    assert values(now)["bank"] == pytest.approx(math.atan(22.0 * 0.2 / GRAVITY))
    assert np.isfinite(list(values(now).values())).all()


def test_estimates_of_target_and_wind_have_their_names():
    told = values(small_uav.situation(target=(10.0, -20.0, 3.0)))
    assert [told[f"target_{axis}"] for axis in ("east", "north", "up")] == [10.0, -20.0, 3.0]
    assert [told[f"wind_{axis}"] for axis in ("east", "north", "up")] == WIND.tolist()
    assert told["target_std"] == 0.7


def test_airspeed_and_surplus_of_the_turn_have_their_names():
    told = values(small_uav.situation(300.0, 0.0, 120.0, 1.6, 0.05, 19.5))
    assert (told["airspeed"], told["surplus"]) == (19.5, 0.02)


@pytest.mark.parametrize("mode", FallbackMode)
def test_the_mode_comes_back_from_its_number(mode):
    assert told_mode(tracking_figures(heard(small_uav.situation(), mode))["mode"]) is mode


@pytest.mark.parametrize("number", [-1.0, 7.0, 0.5, math.nan])
def test_another_number_is_no_mode(number):
    assert told_mode(number) is None


def test_figures_that_are_not_finite_are_left_out():
    message = heard(small_uav.situation())
    message.position[message.name.index("wind_up")] = math.nan
    told = tracking_figures(message)
    assert "wind_up" not in told and told["target_std"] == 0.7


def test_names_without_values_are_refused():
    with pytest.raises(MessageError, match="name has 1 entries"):
        tracking_figures(JointState(name=["bank"]))
