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

"""A simulated vehicle that is flown by commands right and wrong, as Hypothesis makes them up."""

from __future__ import annotations

import copy
import math

import numpy as np
from filled_messages import filled_command
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule
from message_strategies import changed
from node_harness import NodeHarness

from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.invariants import ROUNDING

CONFIGURATION = load_configuration("small_uav")


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
        known = self.parameters
        limit = (known.yaw_rate_max, known.pitch_rate_max, known.acceleration_max)
        message = filled_command(max(0, self.now - age), np.array(inputs) * limit, step)
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
            assert np.all(np.isfinite(vectors)), message
            assert abs(math.hypot(q.x, q.y, q.z, q.w) - 1.0) < 1e-6
            rates = np.abs(vectors[2][1:])
            # Body axes are pitched: both rates together are no greater than the course's.
            allowed = math.hypot(self.parameters.yaw_rate_max, self.parameters.pitch_rate_max)
            assert np.all(rates <= allowed + ROUNDING), rates
        elif topic == AIR_VELOCITY.name:
            speed = message.twist.linear.x
            assert self.parameters.speed_min - 1e-9 <= speed <= self.parameters.speed_max + 1e-9, (
                speed
            )
