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

"""Simulator, target and controller in one process, and somebody who listens and asks."""

import dataclasses

import numpy as np
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from processes import PATIENCE, spin
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes.messages.conversions import plan_from_command
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import load_configuration

# On the orbit, in its clockwise turn; solves may take their time on a slow machine.
ON_ORBIT = (
    "nmpc_controller.direction=clockwise",
    "nmpc_controller.solve_time_max=1.0",
    "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]",
    "uav_simulator.initial_heading=-1.5707963267948966",
)


class Flight:
    """Simulator, target, controller and somebody who listens and asks, in one process.

    The simulator drives the time, which stands while nothing is spun.
    """

    def __init__(self, name="small_uav", *overrides):
        self.context = rclpy.Context()
        self.context.init(args=[])
        self.executor = SingleThreadedExecutor(context=self.context)
        chosen = [*ON_ORBIT, *overrides] if name == "small_uav" else list(overrides)
        self.configuration = load_configuration(name, chosen)
        self.asker = rclpy.create_node("asker", context=self.context)
        self.executor.add_node(self.asker)
        self.commands, self.diagnostics, self.states = [], [], []
        for topic, heard in (
            (COMMAND, self.commands),
            (ODOMETRY, self.states),
            (DIAGNOSTICS, self.diagnostics),
        ):
            self.asker.create_subscription(topic.type, topic.name, heard.append, 100)

    def add(self, node_class, section, **more):
        parameters = getattr(self.configuration, section)
        values = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        }
        node = node_class(
            context=self.context,
            parameter_overrides=[
                Parameter(name, value=list(value) if isinstance(value, tuple) else value)
                for name, value in (values | more).items()
            ],
        )
        self.executor.add_node(node)
        return node

    def add_all(self, speed=5.0, **controller):
        """The three nodes in simulated time, at this speed; None for the wall's time."""
        follow = {"use_sim_time": True} if speed else {}
        drive = {"publish_clock": True, "speed": speed} if speed else {}
        self.target = self.add(TargetPublisher, "target", **follow)
        self.simulator = self.add(UavSimulator, "simulator", **drive)
        self.controller = self.add(NmpcController, "controller", **controller, **follow)

    def spin(self, until, limit=PATIENCE):
        return spin(self.executor, until, limit)

    def fly(self, seconds):
        """Spin until so much simulated time has passed in [s]."""
        now = lambda: self.simulator._now * 1e-9  # noqa: E731
        end = now() + seconds
        assert self.spin(lambda: now() >= end)

    def ask(self, kind, service, node="nmpc_controller", **request):
        client = self.asker.create_client(kind, f"{node}/{service}")
        assert self.spin(client.service_is_ready)
        future = client.call_async(kind.Request(**request))
        assert self.spin(future.done)
        self.asker.destroy_client(client)
        return future.result()

    def change(self, transition):
        return self.ask(ChangeState, "change_state", transition=Transition(id=transition)).success

    def state(self):
        return self.ask(GetState, "get_state").current_state.id

    def set(self, node="nmpc_controller", **values):
        wanted = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        return self.ask(
            SetParametersAtomically, "set_parameters_atomically", node, parameters=wanted
        ).result

    def commanded(self, count=10, limit=PATIENCE):
        """Whether commands come from now on."""
        before = len(self.commands)
        return self.spin(lambda: len(self.commands) >= before + count, limit)

    def told(self, node="nmpc_controller"):
        """The latest diagnostics of the controller, or of another node: message and values."""
        status = self.says(node)[-1]
        return status.message, {value.key: value.value for value in status.values}

    def says(self, node="nmpc_controller"):
        """All that a node has said in diagnostics, oldest first."""
        return [s for message in self.diagnostics for s in message.status if node in s.name]

    def inputs(self):
        return np.array([plan_from_command(message)[0][0] for message in self.commands])

    def end(self):
        for node in self.executor.get_nodes():
            node.destroy_node()
        self.executor.shutdown()
        self.context.try_shutdown()
