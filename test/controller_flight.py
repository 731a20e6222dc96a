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

"""A controller node that is flown by messages right and wrong, as Hypothesis makes them up."""

from __future__ import annotations

import copy
import math
from collections import deque
from typing import ClassVar

import numpy as np
from filled_messages import filled_clock, sensed
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule
from message_strategies import changed

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.invariants import ROUNDING, Invariants
from uav_tracking_mpc.studies.faults.node_campaign import limits
from uav_tracking_mpc.studies.faults.observer import read_command

CONFIGURATION = load_configuration("small_uav")
CLOCKS = (0, 1_000_000_000, 1_700_000_000_000_000_000)  # ns; a flight begins at one of them
TWIN = 10_000_000  # ns from one wrong message to another that bears it out
CALM = 250  # good rounds after which a command must have come
SETTLED = 20  # good rounds, of 50 ms, after which no wrong message counts any more
EFFECT = 0.7  # s until a command takes effect, at most
WRONG_EFFECT = 2.0  # s, where a stamp may be wrong as well


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

    @rule(topic=st.sampled_from((ODOMETRY, TARGET)), data=st.data(), count=st.integers(2, 4))
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
        self.harness.tell(CLOCK.name, filled_clock(stamp + 1_000_000))
        late = list(self.held.values())
        self.held.clear()
        return [*sensed(stamp, self.state, self.place(self.state), inputs).items(), *late]

    def arrive(self, topic, message):
        if topic is AIR_VELOCITY:
            linear = message.twist.linear
            self.airspeeds.append(math.hypot(linear.x, linear.y, linear.z))
        self.answered = message if topic is ODOMETRY else None
        if self.good_rounds > SETTLED:  # nothing is wrong any more
            self.harness.tell(topic.name, message)
        elif self.harness.deliver(topic.name, message):
            self.refused.add(topic.name)
        self.answered = None

    def published(self, topic, message):
        if topic != COMMAND.name:
            return
        plan, starts = read_command(message)
        stamp = nanoseconds(message.header.stamp)
        found = self.judge.command(0.0, stamp * 1e-9, plan, starts)
        assert not found, found
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
        worst = float(np.max(np.abs(plan[:, 0])))
        assert worst <= turning + ROUNDING, f"{worst} rad/s, the bank allows {turning} rad/s"
