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

"""PX4's ROS 2 messages: signs, frames and units, with stand-ins for px4_msgs."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.frames import quaternion_from_euler
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.px4_messages import (
    PathDemand,
    fill_command,
    fill_lateral,
    fill_longitudinal,
    fill_offboard,
    measurement,
    topic,
)

FRAME = LocalFrame(math.radians(47.0), math.radians(8.0), 400.0)


def place(up=100.0):
    return SimpleNamespace(lat=47.0, lon=8.0, alt=400.0 + up)


def odometry(roll=0.0, pitch=0.0, yaw=0.0, velocity=(20.0, 0.0, -2.0), rates=(0.0, 0.0, 0.0)):
    q = quaternion_from_euler(roll, pitch, yaw)
    return SimpleNamespace(
        q=q, velocity=velocity, angular_velocity=rates, velocity_frame=1,
        position_variance=(0.16, 0.25, 1.0), velocity_variance=(0.01, 0.04, math.nan),
    )  # fmt: skip


def airspeed(speed):
    return SimpleNamespace(true_airspeed_m_s=speed)


def level(**changed):
    values = {"stamp": 0.0, "position": np.zeros(3), "ground_velocity": np.zeros(3),
              "heading": 0.0, "path_angle": 0.0, "airspeed": 22.0}  # fmt: skip
    return Measurement(**{**values, **changed})


def test_north_east_down_becomes_map():
    seen = measurement(1.0, place(), odometry(yaw=0.0), airspeed(20.0), FRAME)
    assert seen.position == pytest.approx([0.0, 0.0, 100.0], abs=1e-6)
    assert seen.ground_velocity == pytest.approx([0.0, 20.0, 2.0])
    assert seen.heading == pytest.approx(0.5 * math.pi)
    assert seen.path_angle == pytest.approx(math.asin(0.1))
    assert seen.airspeed == 20.0


def test_variances_to_north_east_and_down_become_those_of_map():
    noise = measurement(1.0, place(), odometry(), None, FRAME).noise
    assert noise.position == pytest.approx((0.5, 0.4, 1.0))
    assert noise.velocity == (0.0, 0.0, 0.0)  # one axis makes no sense
    assert noise.heading == noise.path_angle == 0.0


def test_a_turn_to_the_right_is_clockwise():
    turning = odometry(roll=0.4, rates=(0.0, 0.1 * math.sin(0.4), 0.1 * math.cos(0.4)))
    assert measurement(0.0, place(), turning, None, FRAME).turn_rate == pytest.approx(-0.1)


@pytest.mark.parametrize("speed", [math.nan, 0.0, None])
def test_without_an_airspeed_there_is_none(speed):
    told = None if speed is None else airspeed(speed)
    assert measurement(0.0, place(), odometry(), told, FRAME).airspeed is None


def test_what_is_not_finite_or_in_another_frame_is_no_measurement():
    other = odometry()
    other.velocity_frame = 2
    assert measurement(0.0, place(), other, None, FRAME) is None
    assert measurement(0.0, place(), odometry(velocity=(math.nan, 0, 0)), None, FRAME) is None


def test_lateral_acceleration_is_positive_to_the_right_and_limited():
    message = SimpleNamespace()
    fill_lateral(message, -0.1, 20.0, 1.0)
    assert message.lateral_acceleration == pytest.approx(2.0)
    assert math.isnan(message.course)
    assert math.isnan(message.airspeed_direction)
    fill_lateral(message, 10.0, 20.0, 0.5)
    assert message.lateral_acceleration == pytest.approx(-GRAVITY * math.tan(0.5))


def test_height_rate_is_up_and_the_airspeed_equivalent():
    demand, message = PathDemand(), SimpleNamespace()
    demand.path_angle, demand.airspeed = 0.1, 22.0
    fill_longitudinal(message, demand, 20.0, 2000.0)
    assert message.height_rate == pytest.approx(20.0 * math.sin(0.1))
    # U.S. Standard Atmosphere 1976: sigma = 0.8217 at 2000 m
    assert message.equivalent_airspeed == pytest.approx(22.0 * math.sqrt(0.8217), rel=1e-3)
    assert all(map(math.isnan, (message.altitude, message.pitch_direct, message.throttle_direct)))


def test_the_demand_integrates_and_stays_near_what_is_flown():
    demand = PathDemand()
    demand.step(0.1, 1.0, level(), 0.0)
    for tick in range(1, 11):
        demand.step(0.1, 1.0, level(), 0.1 * tick)
    assert demand.path_angle == pytest.approx(0.1)
    assert demand.airspeed == pytest.approx(23.0)
    for tick in range(11, 100):
        demand.step(0.1, 1.0, level(), 0.1 * tick)
    assert demand.path_angle == pytest.approx(0.15)
    assert demand.airspeed == pytest.approx(25.0)
    demand.step(0.1, 1.0, level(path_angle=-0.05), 20.0)  # after a pause it begins anew
    assert demand.path_angle == pytest.approx(-0.05)


def test_of_offboard_velocity_alone_is_asked():
    message = SimpleNamespace()
    fill_offboard(message)
    assert [name for name, value in vars(message).items() if value] == ["velocity"]


def test_a_command_names_its_sender_and_all_seven_parameters():
    message = SimpleNamespace()
    fill_command(message, 176, 1.0, 6.0)
    assert [getattr(message, f"param{n}") for n in range(1, 8)] == [1.0, 6.0, 0, 0, 0, 0, 0]
    assert (message.command, message.target_system, message.from_external) == (176, 1, True)


def test_versioned_topics_have_a_suffix():
    assert topic("/fmu/out/x", SimpleNamespace(MESSAGE_VERSION=1)) == "/fmu/out/x_v1"
    assert topic("/fmu/out/x", SimpleNamespace(MESSAGE_VERSION=0)) == "/fmu/out/x"
    assert topic("/fmu/out/x", SimpleNamespace()) == "/fmu/out/x"
