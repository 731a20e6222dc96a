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

"""PX4 over ROS 2 as a link, on a wire in memory."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.frames import quaternion_from_euler
from uav_tracking_mpc.nodes.px4_ros_link import ARMED, OFFBOARD, Px4RosLink

HOLD = 4
STEP = 0.02  # s


class Aircraft:
    """Answers as PX4: OFFBOARD where it is asked for while set-points stream."""

    def __init__(self):
        self.time, self.mode, self.failsafe, self.closed = 0.0, HOLD, False, False
        self.arming, self.sent, self.ticks = ARMED, [], 0

    def receive(self, timeout):
        self.time += STEP
        self.ticks += 1
        status = SimpleNamespace(nav_state=self.mode, arming_state=self.arming,
                                 failsafe=self.failsafe)  # fmt: skip
        place = SimpleNamespace(lat=47.0, lon=8.0, alt=500.0)
        odometry = SimpleNamespace(
            q=quaternion_from_euler(0.0, 0.05, 0.0), velocity=(22.0, 0.0, 0.0),
            angular_velocity=(0.0, 0.0, 0.0), velocity_frame=1,
            position_variance=(0.1, 0.1, 0.2), velocity_variance=(0.01, 0.01, 0.01),
        )  # fmt: skip
        speed = SimpleNamespace(true_airspeed_m_s=22.0)
        come = [("AirspeedValidated", speed), ("VehicleGlobalPosition", place)]
        if self.ticks % 10 == 1:
            home = SimpleNamespace(lat=47.0, lon=8.0, alt=400.0)
            come += [("VehicleStatus", status), ("HomePosition", home)]
        return [*come, ("VehicleOdometry", odometry)]

    def send(self, kind, fill):
        message = SimpleNamespace()
        fill(message)
        self.sent.append((self.time, kind, message))
        if kind == "VehicleCommand":
            self.mode = OFFBOARD if message.param2 == 6.0 else HOLD

    def close(self):
        self.closed = True

    def since(self, time, kind="FixedWingLateralSetpoint"):
        return [message for at, name, message in self.sent if at > time and name == kind]


class Link(Px4RosLink):
    """By the aircraft's clock."""

    def __init__(self):
        self.aircraft = Aircraft()
        super().__init__(wire=lambda: self.aircraft)

    def now(self):
        return self.aircraft.time


@pytest.fixture
def link():
    connected = Link()
    connected.connect(5.0)
    return connected


def fly(link, duration, turn_rate=-0.1):
    end = link.now() + duration
    while link.now() < end:
        if link.measured(0.1) is not None:
            link.command(link.now(), np.array([[turn_rate, 0.01, 0.0]] * 3), 0.4)


def test_nothing_is_sent_until_it_is_engaged(link):
    fly(link, 2.0)
    assert link.aircraft.sent == []


def test_offboard_is_asked_for_after_a_second_of_inert_set_points(link):
    fly(link, 0.2)
    begin = link.now()
    assert link.engage() == ""
    fly(link, 3.0)
    assert link.engaged
    asked = next(at for at, kind, _ in link.aircraft.sent if kind == "VehicleCommand")
    assert asked - begin >= 1.0
    inert = [m for at, kind, m in link.aircraft.sent if "Lateral" in kind and at < asked]
    assert len(inert) >= 25
    assert all(message.lateral_acceleration == pytest.approx(0.0) for message in inert)
    assert link.aircraft.since(link.now() - 0.1)[-1].lateral_acceleration == pytest.approx(2.2)
    climb = link.aircraft.since(link.now() - 0.1, "FixedWingLongitudinalSetpoint")[-1]
    assert climb.height_rate > 0.0
    assert math.isfinite(climb.equivalent_airspeed)


def test_a_pilot_takes_over_for_good(link):
    fly(link, 0.2)
    link.engage()
    fly(link, 3.0)
    link.aircraft.mode = 2  # Position
    fly(link, 0.3)
    at = link.now()
    link.aircraft.mode = OFFBOARD
    fly(link, 2.0)
    assert not link.engaged
    assert link.aircraft.since(at) == []


def test_it_gives_command_back_as_a_hold(link):
    fly(link, 0.2)
    link.engage()
    fly(link, 3.0)
    link.close()
    assert link.aircraft.mode == HOLD
    assert link.aircraft.closed


def test_a_disarmed_aircraft_is_refused(link):
    link.aircraft.arming = 1
    fly(link, 0.5)
    assert "disarmed" in link.engage()


def test_a_plan_that_is_not_finite_is_refused_in_words(link):
    assert link.command(link.now(), np.full((3, 3), math.nan), 0.4)
