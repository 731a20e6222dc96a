"""Messages right and wrong into the callbacks of controller and vehicle, found by Hypothesis.

No middleware in between: what a run finds, it finds again. In the suite a few flights; ``pytest -m
long`` flies thousands.
"""

import copy
import math
from collections import deque
from typing import ClassVar

import numpy as np
import pytest

pytest.importorskip("rclpy")

import rclpy
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    rule,
    run_state_machine_as_test,
)
from message_strategies import changed
from node_harness import NodeHarness, start_ros

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.conversions import (
    nanoseconds,
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
    set_stamp,
)
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.fault_campaign import limits
from uav_tracking_mpc.studies.faults.invariants import ROUNDING, Invariants
from uav_tracking_mpc.studies.faults.observer import read_command

pytestmark = [pytest.mark.nodes, pytest.mark.timeout(600)]

CONFIGURATION = load_configuration("small_uav")
CLOCKS = (0, 1_000_000_000, 1_700_000_000_000_000_000)  # ns; a flight begins at one of them
TWIN = 10_000_000  # ns from one wrong message to another that bears it out
CALM = 250  # good rounds after which a command must have come
SETTLED = 20  # good rounds, of 50 ms, after which no wrong message counts any more
EFFECT = 0.7  # s until a command takes effect, at most
WRONG_EFFECT = 2.0  # s, where a stamp may be wrong as well

SHORT = settings(
    max_examples=8,
    stateful_step_count=20,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
LONG = settings(SHORT, max_examples=3000, stateful_step_count=60, derandomize=False)


def advance(state, inputs, duration):
    """Kinematics of (x, y, z, psi, chi, v), shape (6,), over a short time in [s]."""
    x, y, z, psi, chi, v = state
    turn, climb, acceleration = inputs
    return np.array(
        [
            x + duration * v * math.cos(chi) * math.cos(psi),
            y + duration * v * math.cos(chi) * math.sin(psi),
            z + duration * v * math.sin(chi),
            psi + duration * turn,
            chi + duration * climb,
            v + duration * acceleration,
        ]
    )


class ControllerFlight(RuleBasedStateMachine):
    """A controller that is flown by what arrives of the messages of vehicle and target."""

    harness = None
    refused: ClassVar = set()  # names of topics with refused messages, over all flights
    commands = 0  # over all flights

    def __init__(self):
        super().__init__()
        self.parameters = CONFIGURATION.controller
        self.period = 1.0 / CONFIGURATION.simulator.state_rate
        self.judge = Invariants(limits(CONFIGURATION))
        self.plan = None  # when it begins [s], inputs, starts [s]
        self.answered = None  # the state that is being delivered
        self.airspeeds = deque(maxlen=SETTLED)  # received, right and wrong [m/s]
        self.good_rounds = 0  # without a wrong message
        self.held = {}  # messages that lost their turn, by topic
        self.commanded = 0
        self.place = lambda state: np.array(CONFIGURATION.target.position)
        self.harness.restart()
        self.harness.node.controller._stopwatch = lambda: self.harness.clock
        self.harness.published = self.published

    @initialize(
        start=st.sampled_from(CLOCKS),
        distance=st.floats(0.0, 3.0),
        azimuth=st.floats(-math.pi, math.pi),
        altitude=st.floats(0.5, 1.5),
        heading=st.floats(-math.pi, math.pi),
    )
    def take_off(self, start, distance, azimuth, altitude, heading):
        orbit = self.parameters.orbit
        east, north = orbit.range * distance * math.cos(azimuth), math.sin(azimuth)
        north *= orbit.range * distance
        self.start, self.time = start, 0.0
        self.state = np.array([east, north, orbit.altitude * altitude, heading, 0.0, orbit.speed])
        self.rounds(5)

    @rule(count=st.integers(1, 10))
    def rounds(self, count):
        for _ in range(count):
            for topic, message in self.next_round(good=True):
                self.arrive(topic, message)

    @rule(
        topic=st.sampled_from((ODOMETRY, AIR_VELOCITY, TARGET)),
        fate=st.sampled_from(("lost", "twice", "late")),
        count=st.integers(1, 5),
    )
    def disturbed_rounds(self, topic, fate, count):
        for _ in range(count):
            for other, message in self.next_round():
                if other is not topic or fate == "twice":
                    self.arrive(other, message)
                if other is topic and fate == "twice":
                    self.arrive(other, copy.deepcopy(message))
                elif other is topic and fate == "late":
                    self.held[topic.name] = topic, message

    @rule(topic=st.sampled_from((ODOMETRY, AIR_VELOCITY, TARGET)), data=st.data())
    def changed_message(self, topic, data):
        for other, message in self.next_round():
            self.arrive(other, data.draw(changed(message)) if other is topic else message)

    @rule(
        topic=st.sampled_from((ODOMETRY, TARGET)),
        data=st.data(),
        count=st.integers(2, 4),
    )
    def messages_that_bear_each_other_out(self, topic, data, count):
        for other, message in self.next_round():
            if other is not topic:
                self.arrive(other, message)
                continue
            wrong = data.draw(changed(message))
            for _ in range(count):
                self.arrive(topic, copy.deepcopy(wrong))
                stamp = wrong.header.stamp
                stamp.nanosec = min(stamp.nanosec + TWIN, 2**32 - 1)  # sometimes no time

    @rule(offset=st.tuples(*[st.floats(-1e3, 1e3)] * 3), count=st.integers(1, 4))
    def displaced_vehicle(self, offset, count):
        for _ in range(count):
            for topic, message in self.next_round():
                if topic is ODOMETRY:
                    point = message.pose.pose.position
                    point.x, point.y, point.z = (
                        value + step
                        for value, step in zip((point.x, point.y, point.z), offset, strict=True)
                    )
                self.arrive(topic, message)

    @rule(height=st.sampled_from((0.0, 1.0, 2.0)), count=st.integers(1, 5))
    def target_at_the_aircraft(self, height, count):
        """The target below, in and above the aircraft."""
        stays = self.place
        self.place = lambda state: state[:3] * np.array([1.0, 1.0, height])
        self.rounds(count)
        self.place, self.good_rounds = stays, 0

    @rule(pause=st.sampled_from((0.0, 0.3, 1.0, 10.0)))
    def timers(self, pause):
        """Timers are due, perhaps after the process has stood still for some seconds."""
        self.harness.clock += pause
        self.harness.fire()

    @rule()
    def calm(self):
        """With good messages alone the controller is soon back in command."""
        before = self.commanded
        for _ in range(CALM):
            self.rounds(1)
            if self.commanded > before:
                return self.rounds(SETTLED + 5)
        raise AssertionError(f"no command in {CALM} good rounds")

    def next_round(self, good=False):
        """Fly on for a period; what the sensors send then."""
        self.good_rounds = self.good_rounds + 1 if good and not self.held else 0
        inputs = np.zeros(3)
        if self.plan is not None:
            begin, plan, starts = self.plan
            segment = int(np.searchsorted(begin + starts, self.time, side="right")) - 1
            inputs = plan[max(segment, 0)]
        self.state = advance(self.state, inputs, self.period)
        self.time += self.period
        self.harness.clock += self.period
        stamp = self.start + round(self.time * 1e9)
        clock = CLOCK.type()
        set_stamp(clock.clock, stamp + 1_000_000)
        self.harness.tell(CLOCK.name, clock)
        target, air, odometry = TARGET.type(), AIR_VELOCITY.type(), ODOMETRY.type()
        set_point(target, stamp, self.place(self.state))
        set_air_velocity(air, stamp, float(self.state[5]))
        set_odometry(odometry, stamp, self.state, inputs)
        late = list(self.held.values())
        self.held.clear()
        return [(TARGET, target), (AIR_VELOCITY, air), (ODOMETRY, odometry), *late]

    def arrive(self, topic, message):
        if topic is AIR_VELOCITY:
            linear = message.twist.linear
            self.airspeeds.append(math.hypot(linear.x, linear.y, linear.z))
        self.answered = message if topic is ODOMETRY else None
        if self.harness.deliver(topic.name, message):
            self.refused.add(topic.name)
        self.answered = None

    def published(self, topic, message):
        if topic != COMMAND.name:
            return
        plan, starts = read_command(message)
        stamp = nanoseconds(message.header.stamp)
        assert self.judge.command(0.0, stamp * 1e-9, plan, starts) == []
        assert self.answered is not None, "a command without a state"
        assert nanoseconds(self.answered.header.stamp) == stamp, "not the stamp of the state"
        self.check_bank(plan)
        self.plan = (stamp - self.start) * 1e-9, plan, starts
        self.commanded += 1
        type(self).commands += 1

    def check_bank(self, plan):
        """The bank limit, at the least airspeed that the controller may count with."""
        ground = self.answered.twist.twist.linear
        airspeeds = [math.hypot(ground.x, ground.y, ground.z), *self.airspeeds]
        if self.good_rounds > SETTLED:
            airspeeds = [self.state[5]]
        effect = EFFECT if self.good_rounds > SETTLED else WRONG_EFFECT
        left = max(min(airspeeds) + effect * self.parameters.acceleration_min, 1e-3)
        turning = GRAVITY * math.tan(self.parameters.bank_max) / left
        assert np.max(np.abs(plan[:, 0])) <= turning + ROUNDING


class VehicleFlight(RuleBasedStateMachine):
    """A simulated vehicle that is flown by what arrives of random commands."""

    harness = None
    refused = 0  # over all flights
    accepted = 0

    def __init__(self):
        super().__init__()
        self.parameters = CONFIGURATION.simulator
        self.now = 0
        self.harness = type(self).harness = NodeHarness(
            UavSimulator,
            self.parameters,
            refusals=lambda node: node._rejected,
            may_change=("_rejected", "_parameters", "parameters"),
            publish_clock=True,
        )
        self.harness.published = self.published
        self.fly(1)

    def teardown(self):
        self.harness.node.destroy_node()

    @rule(
        inputs=st.lists(st.tuples(*[st.floats(-1.5, 1.5)] * 3), min_size=1, max_size=5),
        step=st.sampled_from((0.05, 0.2, 0.5, 1.0)),
        age=st.integers(0, 100_000_000),
        data=st.data(),
        wrong=st.booleans(),
        copies=st.integers(1, 2),
    )
    def command(self, inputs, step, age, data, wrong, copies):
        """A plan up to half as much again beyond the limits."""
        parameters, message = self.parameters, COMMAND.type()
        limit = (parameters.yaw_rate_max, parameters.pitch_rate_max, parameters.acceleration_max)
        set_command(message, max(0, self.now - age), np.array(inputs) * limit, step)
        if wrong:
            message = data.draw(changed(message))
        for _ in range(copies):
            refused = self.harness.deliver(COMMAND.name, copy.deepcopy(message))
            type(self).refused += refused
            type(self).accepted += not refused
        self.fly(1)

    @rule(count=st.sampled_from((1, 2, 40)))  # in 40 most plans end
    def fly(self, count):
        for _ in range(count):
            self.harness.fire()

    def published(self, topic, message):
        if topic == CLOCK.name:
            self.now = nanoseconds(message.clock)
        elif topic == ODOMETRY.name:
            pose, twist, q = message.pose.pose, message.twist.twist, message.pose.pose.orientation
            vectors = [
                [part.x, part.y, part.z] for part in (pose.position, twist.linear, twist.angular)
            ]
            assert np.all(np.isfinite(vectors))
            assert abs(math.hypot(q.x, q.y, q.z, q.w) - 1.0) < 1e-6
            rates = np.abs(vectors[2][1:])
            # Body axes are pitched: both rates together are no greater than the course's.
            allowed = math.hypot(self.parameters.yaw_rate_max, self.parameters.pitch_rate_max)
            assert np.all(rates <= allowed + ROUNDING)
        elif topic == AIR_VELOCITY.name:
            speed = message.twist.linear.x
            assert self.parameters.speed_min - 1e-9 <= speed <= self.parameters.speed_max + 1e-9


@pytest.fixture(scope="module")
def controller():
    start_ros()
    ControllerFlight.harness = NodeHarness(
        NmpcController,
        CONFIGURATION.controller,
        refusals=lambda node: node.report.refused,
        # The solver's workspace is overwritten by every solve; a doubtful state is remembered, to
        # judge the next ones; the first stamp, whatever it is, is where times are counted from.
        may_change=("formulation", "_outlier", "_agreeing", "reason", "events", "_origin"),
        use_sim_time=True,
    )
    yield ControllerFlight
    ControllerFlight.harness.node.destroy_node()
    rclpy.try_shutdown()


def fly(flight, how):
    """Flights as Hypothesis makes them up; an error that comes once only is told as well."""
    try:
        run_state_machine_as_test(flight, settings=how)
    except BaseException as error:
        raise AssertionError(flight.harness.first_error) from error


def test_no_message_breaks_the_controller(controller):
    fly(controller, SHORT)
    assert controller.commands > 100
    assert controller.refused == {ODOMETRY.name, AIR_VELOCITY.name, TARGET.name}


def test_no_message_breaks_the_vehicle(controller):
    fly(VehicleFlight, SHORT)
    assert VehicleFlight.refused > 20
    assert VehicleFlight.accepted > 20


@pytest.mark.long
@pytest.mark.timeout(0)
@pytest.mark.parametrize("flight", [ControllerFlight, VehicleFlight])
def test_no_message_breaks_anything_in_thousands_of_flights(controller, flight):
    fly(flight, LONG)


def flown(controller):
    """A flight without a wrong message."""
    flight = controller()
    flight.take_off(start=0, distance=1.0, azimuth=0.0, altitude=1.0, heading=0.0)
    flight.rounds(20)


def test_an_exception_in_a_callback_is_found(controller, monkeypatch):
    def careless(message):
        return np.linalg.inv(np.zeros((3, 3))).diagonal()

    monkeypatch.setattr("uav_tracking_mpc.nodes.conversions.position_from_point", careless)
    with pytest.raises(np.linalg.LinAlgError):
        flown(controller)


def test_a_command_outside_the_limits_is_found(controller, monkeypatch):
    write = CommandWire.write
    monkeypatch.setattr(
        CommandWire, "write", lambda wire, stamp, plan, step: write(wire, stamp, 9.0 * plan, step)
    )
    with pytest.raises(AssertionError, match="command limits"):
        flown(controller)


def test_a_refused_command_that_is_flown_all_the_same_is_found(controller, monkeypatch):
    on_command = UavSimulator._on_command

    def careless(self, message):
        self._plant.time += 1.0
        on_command(self, message)

    monkeypatch.setattr(UavSimulator, "_on_command", careless)
    flight = VehicleFlight()
    with pytest.raises(AssertionError, match="a refused message changed"):
        flight.harness.deliver(COMMAND.name, COMMAND.type())
    flight.teardown()
