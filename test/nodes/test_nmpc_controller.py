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
from unittest import mock

import numpy as np
import pytest
import rclpy
from controller_flight import CONFIGURATION
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import NodeHarness, start_ros, vehicle_from_odometry
from processes import spin
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.relative import relative_state
from uav_tracking_mpc.mpc import compiled_method
from uav_tracking_mpc.mpc.compiled_method import CompilationError
from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
    set_air_velocity,
    set_odometry,
    set_point,
    set_stamp,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_from_message
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
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
    TARGET_ODOMETRY,
    TRACKING,
    TRACKING_ERRORS,
)
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.parameters.specification import ParameterError

pytestmark = pytest.mark.nodes
ABOUT = np.array([100.0, 50.0, 3.0])


@pytest.fixture
def controller():
    """The node and what it publishes, in order; the law flies, which needs no compiling."""
    context = rclpy.Context()
    context.init(args=[])
    sent = []

    class Tapped(NmpcController):
        """The node, with a listener on every publisher."""

        def create_publisher(self, kind, topic, *rest, **options):
            publisher = super().create_publisher(kind, topic, *rest, **options)
            publisher.publish = lambda message: sent.append((topic, message))
            return publisher

    node = Tapped(context=context, parameter_overrides=[Parameter("law", value="l1")])
    yield node, sent
    node.finish()
    node.destroy_node()
    context.try_shutdown()


def answered(node, stamp):
    """Tell the node where target and aircraft are."""
    callbacks = {each.topic_name.lstrip("/"): each.callback for each in node.subscriptions}
    seen, state, air = TARGET.type(), ODOMETRY.type(), AIR_VELOCITY.type()
    set_point(seen, stamp, ABOUT)
    set_odometry(state, stamp, np.array([300.0, 50.0, 60.0, 1.6, 0.0, 10.0]), np.zeros(3))
    set_air_velocity(air, stamp, 10.0)
    callbacks[AIR_VELOCITY.name](air)
    callbacks[TARGET.name](seen)
    callbacks[ODOMETRY.name](serialize_message(state))


def test_the_orbit_follows_the_command_with_its_stamp(controller):
    node, sent = controller
    stamp = node.get_clock().now().nanoseconds
    answered(node, stamp)
    topics = [topic for topic, _ in sent]
    assert topics.index(COMMAND.name) + 1 == topics.index(ORBIT.name)
    message = dict(sent)[ORBIT.name]
    orbit, wanted = orbit_from_message(message), node.controller.orbit
    assert nanoseconds(message.header.stamp) == stamp
    above = ABOUT + np.array([0.0, 0.0, wanted.altitude])
    np.testing.assert_allclose(orbit.centre, above, atol=1e-6)
    assert abs(orbit.radius) == pytest.approx(wanted.radius)
    assert orbit.airspeed == wanted.speed


def test_whether_the_commands_are_flown_reaches_the_controller(controller):
    node, _ = controller
    told = []
    node.controller.engage = told.append
    node._on_engaged(ENGAGED.type(data=False))
    node._on_engaged(ENGAGED.type(data=True))
    assert told == [False, True]


pytest.importorskip("rclpy")


class Compiling:
    """A compilation that goes on until it is made to fail."""

    failed = False

    def __init__(self, folder, aside):
        pass

    def done(self):
        if self.failed:
            raise CompilationError("no compiler")
        return False


class Flight(NodeHarness):
    """A controller node that answers states of an aircraft on its orbit, as late as it is told."""

    def __init__(self, **parameters):
        quiet = {"delay_margin_min": 0.0, "gain_margin_min": 0.0, "use_sim_time": True}
        super().__init__(NmpcController, CONFIGURATION.controller, None, (), **quiet, **parameters)
        self.clock = time.monotonic()  # when it was activated
        self.statuses, self.takes = [], 0.0
        self.published = self.hear
        self.node.controller._stopwatch = lambda: self.clock
        solve = self.node.controller.formulation.solve
        self.log = mock.Mock()
        self.node.get_logger = lambda: self.log

        def slow(*arguments):
            self.clock += self.takes
            return solve(*arguments)

        self.node.controller.formulation.solve = slow

    def hear(self, topic, message):
        if topic.endswith("diagnostics"):
            self.statuses += message.status

    def state(self):
        """The next state, 50 ms after the last answer, in time."""
        self.clock += 0.05
        stamp = round(self.clock * 1e9)
        target, air, odometry = TARGET.type(), AIR_VELOCITY.type(), ODOMETRY.type()
        set_point(target, stamp, np.zeros(3))
        set_air_velocity(air, stamp, 22.0)
        turn = self.clock * 22.0 / 300.0
        place = [300.0 * np.cos(turn), 300.0 * np.sin(turn), 120.0, turn + np.pi / 2.0, 0.0, 22.0]
        set_odometry(odometry, stamp, np.array(place), np.array([22.0 / 300.0, 0.0, 0.0]))
        self.tell(TARGET.name, target)
        self.tell(AIR_VELOCITY.name, air)
        self.tell(ODOMETRY.name, odometry)


@pytest.fixture
def ros():
    start_ros()
    yield
    rclpy.try_shutdown()


def test_while_the_solver_is_compiled_that_is_the_one_status(ros, monkeypatch):
    monkeypatch.setattr(compiled_method, "Compilation", Compiling)
    monkeypatch.setattr(compiled_method.machine_code, "finished", lambda folder: False)
    flight = Flight()
    flight.state()
    flight.statuses.clear()
    flight.takes = 2.0
    for _ in range(6):
        flight.state()
        flight.fire()
    shown = {(status.level, status.message) for status in flight.statuses}
    assert shown == {(b"\x01", "the solver is being compiled")}
    assert flight.node.report.refused >= 2  # answers that came too late
    said = [call.args[0] for call in flight.log.warning.call_args_list]
    assert said == ["the solver is being compiled: a slower one solves meanwhile"]
    flight.log.error.assert_not_called()
    monkeypatch.setattr(Compiling, "failed", True)
    for _ in range(3):
        flight.state()
    assert flight.statuses[-1].message == "the own solve is late: no command is sent"
    flight.node.destroy_node()


def test_a_lost_state_says_who_is_late(ros):
    flight = Flight()
    modes = flight.node.controller.modes
    for _ in range(10):
        flight.state()
    flight.takes = 2.0
    for _ in range(3):
        flight.state()
        flight.fire()
        assert modes.reason == "the own solve is late"
    flight.takes = 0.0
    for _ in range(5):
        flight.state()
    assert modes.reason == ""
    flight.clock += 0.3
    flight.fire()
    flight.clock += 0.3
    flight.fire()
    assert modes.reason.endswith("nothing usable comes on uav/odometry: its sender is late or gone")
    flight.node.destroy_node()


@pytest.fixture
def executor():
    context = rclpy.Context()
    context.init(args=[])
    executor = SingleThreadedExecutor(context=context)
    executor.context_of_nodes = context
    yield executor
    for node in executor.get_nodes():
        node.destroy_node()
    executor.shutdown()
    context.try_shutdown()


def add(executor, node_class, **parameters):
    node = node_class(
        context=executor.context_of_nodes,
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()],
    )
    executor.add_node(node)
    return node


def listen(executor, *topics):
    node = rclpy.create_node("listener", context=executor.context_of_nodes)
    heard = {topic.name: [] for topic in topics}
    for topic in topics:
        node.create_subscription(topic.type, topic.name, heard[topic.name].append, 100)
    executor.add_node(node)
    return heard


def test_all_nodes_fly_onto_the_orbit(executor):
    views = (PREDICTED_PATH, MARKERS, DIAGNOSTICS, TRACKING_ERRORS, *TRACKING.values())
    heard = listen(executor, ODOMETRY, COMMAND, TARGET, *views)
    add(executor, TargetPublisher, use_sim_time=True)
    controller = add(executor, NmpcController, use_sim_time=True)
    add(executor, UavSimulator, publish_clock=True, speed=10.0, start_on_command=True)

    def errors():
        if not heard[ODOMETRY.name]:
            return np.full(5, np.inf)
        state = vehicle_from_odometry(heard[ODOMETRY.name][-1])
        return relative_state(state, np.zeros(3)) - controller.parameters.orbit.steady_state

    assert spin(executor, lambda: np.all(np.abs(errors()[[0, 2, 4]]) < [1.0, 1.0, 0.1]), 60.0)
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
    names = {status.name for message in heard[DIAGNOSTICS.name] for status in message.status}
    assert names == {"uav_simulator: status", "target_publisher: status", "nmpc_controller: status"}


def test_the_last_diagnostics_say_that_a_node_has_ended(executor):
    heard = listen(executor, ODOMETRY, DIAGNOSTICS)
    nodes = [
        add(executor, TargetPublisher, use_sim_time=True),
        add(executor, NmpcController, use_sim_time=True),
        add(executor, UavSimulator, publish_clock=True, speed=10.0, start_on_command=True),
    ]

    def last():
        statuses = [each for message in heard[DIAGNOSTICS.name] for each in message.status]
        return {status.name.partition(":")[0]: status for status in statuses}

    assert spin(executor, lambda: "tracking" in str(last().get("nmpc_controller")))
    for node in nodes:
        node.finish()
        executor.remove_node(node)
    names = {node.get_name() for node in nodes}
    assert spin(
        executor, lambda: {n for n, each in last().items() if each.message == "ended"} == names
    )
    assert all(status.level == DiagnosticStatus.STALE for status in last().values())
    assert all(status.values for status in last().values())
    for node in nodes:
        node.destroy_node()


def test_controller_is_silent_without_a_target(executor):
    heard = listen(executor, COMMAND, ODOMETRY, DIAGNOSTICS)
    add(executor, NmpcController)
    add(executor, UavSimulator)
    assert spin(executor, lambda: len(heard[ODOMETRY.name]) > 30)
    assert not heard[COMMAND.name]
    words = [s.message for message in heard[DIAGNOSTICS.name] for s in message.status]
    assert "no target position: no command is sent" in words


def test_bad_messages_are_refused_and_flight_goes_on(executor):
    heard = listen(executor, COMMAND, DIAGNOSTICS)
    add(executor, TargetPublisher)
    controller = add(executor, NmpcController)
    sender = rclpy.create_node("sender", context=executor.context_of_nodes)
    executor.add_node(sender)
    publisher = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    state = np.array([180.0, 0.0, 40.0, 2.0, 0.0, 4.0])

    def send():
        send.count += 1
        message = ODOMETRY.type()
        set_odometry(message, send.count * 100_000_000, state, np.zeros(3))
        if send.count % 2:
            message.pose.pose.position.x = float("nan")
        publisher.publish(message)

    send.count = sender.get_clock().now().nanoseconds // 100_000_000
    sender.create_timer(0.05, send)
    assert spin(executor, lambda: len(heard[COMMAND.name]) > 20)
    assert controller.report.refused > 10
    for message in heard[COMMAND.name]:
        assert np.all(np.isfinite(plan_from_command(message)[0]))


def test_simulator_tells_ground_velocity_airspeed_and_rates_apart(executor):
    heard = listen(executor, ODOMETRY, AIR_VELOCITY)
    wind = [3.0, -2.0, 0.5]
    simulator = add(
        executor,
        UavSimulator,
        publish_clock=True,
        speed=10.0,
        initial_speed=8.0,
        initial_path_angle=0.3,
        wind=wind,
    )
    assert spin(
        executor,
        lambda: min(len(heard[name]) for name in (ODOMETRY.name, AIR_VELOCITY.name)) > 5,
        20.0,
    )
    odometry, air = heard[ODOMETRY.name][-2], heard[AIR_VELOCITY.name][-2]
    motion = measurement_from_odometry(odometry)
    airspeed = air_velocity_from_twist(air)[0]
    assert airspeed == pytest.approx(8.0)
    expected = vehicle.velocity(motion.state(airspeed)) + wind
    np.testing.assert_allclose(motion.ground_velocity, expected, atol=1e-9)
    assert motion.turn_rate == pytest.approx(0.0, abs=1e-12)
    assert motion.path_angle_rate < -0.05  # wings level: the path angle is taken out
    assert simulator._values()["wind north [m/s]"] == -2.0


def test_target_is_published_late_with_the_stamp_of_measuring(executor):
    node = rclpy.create_node("listener", context=executor.context_of_nodes)
    ages, stamps = [], []

    def on_target(message):
        stamps.append(nanoseconds(message.header.stamp))
        ages.append((node.get_clock().now().nanoseconds - stamps[-1]) * 1e-9)

    node.create_subscription(TARGET.type, TARGET.name, on_target, 100)
    executor.add_node(node)
    add(executor, TargetPublisher, rate=20.0, delay=0.33, dropout=0.5)
    assert spin(executor, lambda: len(ages) > 20)
    assert min(ages) >= 0.33
    assert np.median(ages) < 0.43
    assert np.median(np.diff(stamps)) > 0.049e9
    assert np.max(np.diff(stamps)) > 0.09e9  # some are lost


def test_after_the_clock_went_back_commands_flow_again(executor):
    heard = listen(executor, COMMAND)
    controller = add(executor, NmpcController)
    sender = rclpy.create_node("sender", context=executor.context_of_nodes)
    executor.add_node(sender)
    odometry = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    target = sender.create_publisher(TARGET.type, TARGET.name, TARGET.qos)
    state = np.array([180.0, 0.0, 40.0, 2.0, 0.0, 4.0])

    def send():
        send.stamp += 100_000_000
        message = ODOMETRY.type()
        set_odometry(message, send.stamp, state, np.zeros(3))
        odometry.publish(message)
        message = TARGET.type()
        set_point(message, send.stamp + send.ahead, np.zeros(3))
        target.publish(message)

    send.stamp, send.ahead = 100_000_000_000, 0
    sender.create_timer(0.02, send)
    assert spin(executor, lambda: len(heard[COMMAND.name]) > 5)
    send.stamp = 1_000_000_000
    heard[COMMAND.name].clear()
    assert spin(executor, lambda: len(heard[COMMAND.name]) > 5)
    # A target by another clock is no target: the last known place is circled.
    send.ahead = 3_600_000_000_000
    assert spin(executor, lambda: controller.controller.modes.mode is FallbackMode.LOITER)
    heard[COMMAND.name].clear()
    assert spin(executor, lambda: len(heard[COMMAND.name]) > 5)
    # The right clock brings it back.
    send.ahead = 0
    assert spin(executor, lambda: controller.controller.modes.mode is FallbackMode.OPTIMAL)


def test_odometry_of_the_target_counts_instead_of_its_position(executor):
    """Together, one after the other, and when the odometry stays away."""
    controller = add(executor, NmpcController)
    hear = {s.topic_name.lstrip("/"): s.callback for s in controller.subscriptions}
    position, odometry = TARGET.type(), TARGET_ODOMETRY.type()
    odometry.header.frame_id = "map"
    odometry.twist.twist.linear.x = 5.0
    odometry.pose.covariance[0] = odometry.pose.covariance[7] = 0.01
    target, second = controller.controller.navigator.target, 1_000_000_000
    for k in range(20):
        stamp = 100 * second + k * second // 10
        set_stamp(odometry.header.stamp, stamp)
        odometry.pose.pose.position.x = 0.5 * k
        hear[TARGET_ODOMETRY.name](odometry)
        set_point(position, stamp + second // 20, np.array([0.0, 500.0, 0.0]))
        hear[TARGET.name](position)
    assert (target.rejected, target.late) == (0, 0)
    estimate = target.predict(target.time)
    np.testing.assert_allclose(estimate.position, [9.5, 0.0, 0.0], atol=0.1)
    np.testing.assert_allclose(estimate.velocity, [5.0, 0.0, 0.0], atol=0.1)
    timeout = round(controller.parameters.target_timeout * 1e9)
    for k in range(3):
        set_point(position, stamp + timeout + (1 + k) * second, np.array([0.0, 500.0, 0.0]))
        hear[TARGET.name](position)
    assert target.jumps == 1


def test_one_state_with_an_old_stamp_is_not_answered(executor):
    heard = listen(executor, COMMAND)
    add(executor, NmpcController)
    sender = rclpy.create_node("sender", context=executor.context_of_nodes)
    executor.add_node(sender)
    odometry = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    target = sender.create_publisher(TARGET.type, TARGET.name, TARGET.qos)
    state = np.array([180.0, 0.0, 40.0, 2.0, 0.0, 4.0])

    def send():
        send.count += 1
        stamp = 100_000_000_000 + send.count * 100_000_000
        message = TARGET.type()
        set_point(message, stamp, np.zeros(3))
        target.publish(message)
        message = ODOMETRY.type()
        set_odometry(message, stamp - 5_000_000_000 * (send.count % 3 == 0), state, np.zeros(3))
        odometry.publish(message)

    send.count = 0
    sender.create_timer(0.05, send)
    assert spin(executor, lambda: len(heard[COMMAND.name]) > 30)
    stamps = [nanoseconds(message.header.stamp) for message in heard[COMMAND.name]]
    assert stamps == sorted(stamps)


@pytest.mark.parametrize(
    ("node_class", "parameters", "words"),
    [
        (NmpcController, {"range": 40.0}, "range is 40.0 m"),
        (NmpcController, {"horizon": 0}, "'horizon' is 0, must be an integer from 1 to 200"),
        (NmpcController, {"state_weights": [1.0]}, "a list of 5 numbers"),
        (NmpcController, {"airspeed": float("nan")}, "'airspeed' is nan"),
        (UavSimulator, {"initial_speed": 50.0}, "'initial_speed' is 50.0"),
        (TargetPublisher, {"motion": "hop"}, "must be one of circle, jump, line"),
        (TargetPublisher, {"noise": "much"}, "'noise' is 'much'"),
    ],
)
def test_bad_parameters_are_refused_with_name_value_and_range(
    executor, node_class, parameters, words
):
    with pytest.raises(ParameterError, match=words):
        add(executor, node_class, **parameters)


def test_integers_may_stand_for_numbers(executor):
    assert add(executor, NmpcController, range=160).parameters.range == 160.0


@pytest.mark.parametrize("node_class", [UavSimulator, TargetPublisher, NmpcController])
def test_every_parameter_is_described(executor, node_class):
    node = add(executor, node_class)
    from uav_tracking_mpc.parameters.specification import specifications

    for specification in specifications(type(node.parameters)):
        descriptor = node.describe_parameter(specification.name)
        assert specification.description in descriptor.description
        assert specification.allowed in descriptor.additional_constraints
        fixed = specification.fixed and node_class is not NmpcController  # that can be unconfigured
        assert descriptor.read_only == fixed
