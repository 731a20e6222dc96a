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

"""The controller's node among the others: what it is sent, answers and refuses."""

from __future__ import annotations

import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from filled_messages import SECOND, filled_odometry, filled_point, sensed
from node_harness import callback, tapped, vehicle_from_odometry
from rclpy.parameter import Parameter

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.relative import relative_state
from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
    set_stamp,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_from_message
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros.managed_node import Stage
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    MARKERS,
    ODOMETRY,
    ORBIT,
    PREDICTED_PATH,
    TARGET,
    TARGET_GOAL,
    TARGET_ODOMETRY,
    TRACKING,
    TRACKING_ERRORS,
)
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.parameters.specification import specifications

pytestmark = pytest.mark.nodes
ABOUT = np.array([100.0, 50.0, 3.0])
STATE = [180.0, 0.0, 40.0, 2.0, 0.0, 4.0]


def test_the_orbit_follows_the_command_with_its_stamp(nodes):
    sent = []  # the law flies, which needs no compiling
    node = nodes.add(tapped(NmpcController, lambda *heard: sent.append(heard)), law="l1")
    stamp = node.get_clock().now().nanoseconds
    for topic, message in sensed(stamp, [300.0, 50.0, 60.0, 1.6, 0.0, 10.0], ABOUT).items():
        callback(node, topic.name)(message)
    topics = [topic for topic, _ in sent]
    assert topics.index(COMMAND.name) + 1 == topics.index(ORBIT.name)
    message = dict(sent)[ORBIT.name]
    orbit, wanted = orbit_from_message(message), node.controller.orbit
    assert nanoseconds(message.header.stamp) == stamp
    above = ABOUT + np.array([0.0, 0.0, wanted.altitude])
    np.testing.assert_allclose(orbit.centre, above, atol=1e-6)
    assert abs(orbit.radius) == pytest.approx(wanted.radius)
    assert orbit.airspeed == wanted.speed


def test_whether_the_commands_are_flown_reaches_the_controller(nodes):
    node, told = nodes.add(NmpcController, law="l1"), []
    node.controller.engage = told.append
    node._on_engaged(ENGAGED.type(data=False))
    node._on_engaged(ENGAGED.type(data=True))
    assert told == [False, True]


def test_without_their_sender_the_commands_count_as_flown(nodes):
    node, told = nodes.add(NmpcController, law="l1"), []
    node.controller.engage = told.append
    link = nodes.peer("link")
    publisher = link.create_publisher(ENGAGED.type, ENGAGED.name, ENGAGED.qos)
    assert nodes.spin(publisher.get_subscription_count)
    publisher.publish(ENGAGED.type(data=False))
    assert nodes.spin(lambda: told == [False])
    link.destroy_publisher(publisher)
    assert nodes.spin(lambda: told == [False, True])


def test_all_nodes_fly_onto_the_orbit_and_say_that_they_have_ended(nodes):
    views = (PREDICTED_PATH, MARKERS, DIAGNOSTICS, TRACKING_ERRORS, *TRACKING.values())
    heard = nodes.listen(ODOMETRY, COMMAND, TARGET, *views)
    target = nodes.add(TargetPublisher, use_sim_time=True)
    controller = nodes.add(NmpcController, use_sim_time=True)
    simulator = nodes.add(UavSimulator, publish_clock=True, speed=10.0, start_on_command=True)

    def settled():
        state = vehicle_from_odometry(heard[ODOMETRY.name][-1])
        error = relative_state(state, np.zeros(3)) - controller.parameters.orbit.steady_state
        return np.all(np.abs(error[[0, 2, 4]]) < [1.0, 1.0, 0.1])

    assert nodes.spin(lambda: heard[ODOMETRY.name] and settled())
    assert all(heard[topic.name] for topic in (TARGET, PREDICTED_PATH, MARKERS, DIAGNOSTICS))
    commands = np.array([plan_from_command(message)[0][0] for message in heard[COMMAND.name]])
    assert np.all(np.isfinite(commands))
    assert np.all(np.abs(commands) <= [np.pi / 4, np.pi / 4, 1.0])
    states = {nanoseconds(message.header.stamp) for message in heard[ODOMETRY.name]}
    stamps = [nanoseconds(message.header.stamp) for message in heard[COMMAND.name]]
    assert len(states.intersection(stamps)) > 0.9 * len(stamps)  # each bears its state's stamp
    costs = [message.data for message in heard[TRACKING["cost"].name]]
    assert costs[-1] < 1e-2 * costs[0]
    tracked = heard[TRACKING_ERRORS.name][-1]
    assert nanoseconds(tracked.header.stamp) in states
    assert abs(dict(zip(tracked.name, tracked.position, strict=True))["range_error"]) < 2.0
    assert all(point.transforms for point in heard[COMMAND.name][-1].points)

    def last():
        statuses = [each for message in heard[DIAGNOSTICS.name] for each in message.status]
        return {status.name.partition(":")[0]: status for status in statuses}

    flying = {"uav_simulator": simulator, "target_publisher": target, "nmpc_controller": controller}
    assert last().keys() == flying.keys()
    assert nodes.spin(lambda: "tracking" in last()["nmpc_controller"].message)
    for node in flying.values():
        node.finish()
        nodes.executor.remove_node(node)
    assert nodes.spin(lambda: all(each.message == "ended" for each in last().values()))
    assert all(status.level == DiagnosticStatus.STALE for status in last().values())
    assert all(status.values for status in last().values())


def test_controller_is_silent_without_a_target(nodes):
    heard = nodes.listen(COMMAND, ODOMETRY, DIAGNOSTICS)
    nodes.add(NmpcController)
    nodes.add(UavSimulator, state_rate=50.0)
    assert nodes.spin(lambda: len(heard[ODOMETRY.name]) > 30)
    assert not heard[COMMAND.name]
    words = [s.message for message in heard[DIAGNOSTICS.name] for s in message.status]
    assert "no target position: no command is sent" in words


def test_a_silence_is_noticed_by_the_timeout_of_now(nodes):
    node = nodes.add(NmpcController, law="l1", state_timeout=60.0)
    heard = nodes.listen(DIAGNOSTICS)[DIAGNOSTICS.name]
    assert node.set_parameters([Parameter("state_timeout", value=0.2)])[0].successful
    begin = time.monotonic()
    words = "nothing usable comes on uav/odometry: its sender is late"
    assert nodes.spin(lambda: any(words in s.message for m in heard for s in m.status))
    assert time.monotonic() - begin < 25.0  # and not after half of what it was


def test_a_state_that_is_refused_is_not_called_silence(nodes):
    heard = nodes.listen(DIAGNOSTICS)[DIAGNOSTICS.name]
    nodes.add(NmpcController, law="l1")

    def astray():
        message = filled_odometry(time.time_ns(), STATE)
        message.header.frame_id = "odom"
        return {ODOMETRY: message}

    nodes.send(astray, 0.05)
    words = "the last message was refused: uav/odometry: header.frame_id is 'odom'"
    assert nodes.spin(lambda: any(words in s.message for m in heard for s in m.status))


FAILING = """
from uav_tracking_mpc.simulation.motions import TargetMotion

class Failing(TargetMotion):
    name = "failing"

    def position(self, time):
        if {failing}:
            {failure}
        return self._start

    def velocity(self, time):
        return 0.0 * self._start
"""


@pytest.mark.parametrize("failure", ["raise OSError('the map has an edge')", "return [1.0, 2.0]"])
def test_a_motion_that_fails_ends_no_node(nodes, tmp_path, failure):
    """It is told, and no place is published while there is none."""
    file = tmp_path / "motion.py"
    file.write_text(FAILING.format(failing="0.3 < time < 1.0", failure=failure))
    heard = nodes.listen(DIAGNOSTICS, TARGET)
    nodes.add(TargetPublisher, motion=f"{file}:Failing", rate=50.0)
    words = "the motion failed, no position is published"
    reports = heard[DIAGNOSTICS.name]
    assert nodes.spin(lambda: any(words in s.message for m in reports for s in m.status))
    told = len(heard[TARGET.name])
    assert nodes.spin(lambda: len(heard[TARGET.name]) > told + 5)


def test_a_motion_that_cannot_be_taken_up_is_told_until_another_one_is(nodes, monkeypatch):
    node = nodes.add(TargetPublisher)
    change = node._target.change

    def fail(*arguments):
        raise OSError("the map has an edge")

    monkeypatch.setattr(node._target, "change", fail)
    node.set_parameters([Parameter("motion", value="line")])
    node._measure()
    words = "the motion failed, the one before goes on: the map has an edge"
    assert node._diagnostics.status.message == words
    node._unchanged = ""
    monkeypatch.setattr(node._target, "go_to", fail)
    callback(node, TARGET_GOAL.name)(filled_point(0))
    assert node._unchanged == words
    monkeypatch.setattr(node._target, "change", change)
    node.set_parameters([Parameter("motion", value="circle")])
    assert node._target.parameters.motion == "circle"
    assert not node._unchanged  # what is shown may stay for some seconds


def test_a_change_that_fails_half_way_is_told_and_ends_no_node(nodes, monkeypatch, capfd):
    node = nodes.add(NmpcController, law="l1")

    def fail(**_):
        raise RuntimeError("of a limit")

    monkeypatch.setattr(node.controller, "change", fail)
    assert node.set_parameters_atomically([Parameter("range", value=160.0)]).successful
    assert "taken in part: of a limit" in capfd.readouterr().err


def test_what_happened_last_is_logged_before_the_controller_is_gone(nodes, capfd):
    node = nodes.add(NmpcController, law="l1")
    node.controller.events.add(Level.WARNING, "the record ends")
    node.report.at(Stage.UNCONFIGURED, "")
    assert "the record ends" in capfd.readouterr().err


def test_bad_messages_are_refused_and_flight_goes_on(nodes):
    heard = nodes.listen(COMMAND, DIAGNOSTICS)
    nodes.add(TargetPublisher)
    controller = nodes.add(NmpcController)
    stamp = controller.get_clock().now().nanoseconds

    def states():
        nonlocal stamp
        stamp += SECOND // 10
        states.good = not states.good
        return {ODOMETRY: filled_odometry(stamp, STATE if states.good else [np.nan, *STATE[1:]])}

    states.good = True
    nodes.send(states, 0.02)
    assert nodes.spin(lambda: len(heard[COMMAND.name]) > 20)
    assert controller.report.refused > 10
    for message in heard[COMMAND.name]:
        assert np.all(np.isfinite(plan_from_command(message)[0]))


def test_simulator_tells_ground_velocity_airspeed_and_rates_apart(nodes):
    heard = nodes.listen(ODOMETRY, AIR_VELOCITY)
    wind, start = [3.0, -2.0, 0.5], {"initial_speed": 8.0, "initial_path_angle": 0.3}
    simulator = nodes.add(UavSimulator, publish_clock=True, speed=10.0, wind=wind, **start)
    assert nodes.spin(lambda: min(map(len, heard.values())) > 5)
    odometry, air = (messages[-2] for messages in heard.values())
    motion = measurement_from_odometry(odometry)
    airspeed = air_velocity_from_twist(air)[0]
    assert airspeed == pytest.approx(8.0)
    expected = vehicle.velocity(motion.state(airspeed)) + wind
    np.testing.assert_allclose(motion.ground_velocity, expected, atol=1e-9)
    assert motion.turn_rate == pytest.approx(0.0, abs=1e-12)
    assert motion.path_angle_rate < -0.05  # wings level: the path angle is taken out
    assert simulator._values()["wind north [m/s]"] == -2.0


def test_target_is_published_late_with_the_stamp_of_measuring(nodes):
    node, ages, stamps = nodes.peer("listener"), [], []

    def on_target(message):
        stamps.append(nanoseconds(message.header.stamp))
        ages.append((node.get_clock().now().nanoseconds - stamps[-1]) * 1e-9)

    node.create_subscription(TARGET.type, TARGET.name, on_target, 100)
    nodes.add(TargetPublisher, rate=50.0, delay=0.33, dropout=0.5)
    assert nodes.spin(lambda: len(ages) > 20)
    assert min(ages) >= 0.33
    assert np.median(ages) < 0.43
    assert np.median(np.diff(stamps)) > 0.019e9
    assert np.max(np.diff(stamps)) > 0.039e9  # some are lost


class Sensors:
    """State and target every tenth of a second of time that jumps as a test says."""

    stamp, ahead = 100 * SECOND, 0  # ahead: of the target's clock

    def __call__(self):
        self.stamp += SECOND // 10
        return {
            TARGET: filled_point(self.stamp + self.ahead),
            ODOMETRY: filled_odometry(self.stamp, STATE),
        }


def test_after_the_clock_went_back_commands_flow_again(nodes):
    commands, sensors = nodes.listen(COMMAND)[COMMAND.name], Sensors()
    modes = nodes.add(NmpcController).controller.modes
    nodes.send(sensors, 0.02)
    assert nodes.spin(lambda: len(commands) > 5)
    sensors.stamp = SECOND
    commands.clear()
    assert nodes.spin(lambda: len(commands) > 5)
    # A target by another clock is no target: the last known place is circled.
    sensors.ahead = 3600 * SECOND
    assert nodes.spin(lambda: modes.mode is FallbackMode.LOITER)
    commands.clear()
    assert nodes.spin(lambda: len(commands) > 5)
    # The right clock brings it back.
    sensors.ahead = 0
    assert nodes.spin(lambda: modes.mode is FallbackMode.OPTIMAL)


def test_odometry_of_the_target_counts_instead_of_its_position(nodes):
    """Together, one after the other, and when the odometry stays away."""
    controller = nodes.add(NmpcController)
    odometry, place = TARGET_ODOMETRY.type(), [0.0, 500.0, 0.0]
    odometry.header.frame_id = "map"
    odometry.twist.twist.linear.x = 5.0
    odometry.pose.covariance[0] = odometry.pose.covariance[7] = 0.01
    target = controller.controller.navigator.target
    see, track = callback(controller, TARGET.name), callback(controller, TARGET_ODOMETRY.name)
    for k in range(20):
        stamp = 100 * SECOND + k * SECOND // 10
        set_stamp(odometry.header.stamp, stamp)
        odometry.pose.pose.position.x = 0.5 * k
        track(odometry)
        see(filled_point(stamp + SECOND // 20, place))
    assert (target.rejected, target.late) == (0, 0)
    position, velocity, _ = target.motion(target.time)
    np.testing.assert_allclose(position, [9.5, 0.0, 0.0], atol=0.1)
    np.testing.assert_allclose(velocity, [5.0, 0.0, 0.0], atol=0.1)
    timeout = round(controller.parameters.target_timeout * 1e9)
    for k in range(3):
        see(filled_point(stamp + timeout + (1 + k) * SECOND, place))
    assert target.jumps == 1


def test_one_state_with_an_old_stamp_is_not_answered(nodes):
    commands, sensors = nodes.listen(COMMAND)[COMMAND.name], Sensors()
    nodes.add(NmpcController)

    def send():
        messages = sensors()
        if sensors.stamp % (3 * SECOND // 10) == 0:
            set_stamp(messages[ODOMETRY].header.stamp, sensors.stamp - 5 * SECOND)
        return messages

    nodes.send(send, 0.02)
    assert nodes.spin(lambda: len(commands) > 30)
    stamps = [nanoseconds(message.header.stamp) for message in commands]
    assert stamps == sorted(stamps)


def test_integers_may_stand_for_numbers(nodes):
    assert nodes.add(NmpcController, range=160).parameters.range == 160.0


@pytest.mark.parametrize("node_class", [UavSimulator, TargetPublisher, NmpcController])
def test_every_parameter_is_described(nodes, node_class):
    node = nodes.add(node_class)
    for specification in specifications(type(node.parameters)):
        descriptor = node.describe_parameter(specification.name)
        assert specification.description in descriptor.description
        assert specification.allowed in descriptor.additional_constraints
        fixed = specification.fixed and node_class is not NmpcController  # that can be unconfigured
        assert descriptor.read_only == fixed
