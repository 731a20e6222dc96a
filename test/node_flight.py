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

from dataclasses import asdict

import numpy as np
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from node_harness import Nodes
from processes import PATIENCE
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes.autopilot_link import AutopilotLink
from uav_tracking_mpc.nodes.messages.conversions import plan_from_command
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.settings.configuration import load_configuration

NODES = {
    "uav_simulator": UavSimulator,
    "target_publisher": TargetPublisher,
    "nmpc_controller": NmpcController,
    "autopilot_link": AutopilotLink,
}
# On the orbit, in its clockwise turn.
ON_ORBIT = (
    "nmpc_controller.direction=clockwise",
    "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]",
    "uav_simulator.initial_heading=-1.5707963267948966",
)
PATIENT = "nmpc_controller.solve_time_max=1.0"  # solves may take their time on a slow machine


class Flight(Nodes):
    """Simulator, target, controller and somebody who listens and asks, in one process.

    The simulator drives the time, which stands while nothing is spun.
    """

    def __init__(self, name="small_uav", *changes):
        super().__init__()
        chosen = [*ON_ORBIT, PATIENT, *changes] if name == "small_uav" else changes
        self.configuration = load_configuration(name, chosen)
        self.asker = self.peer("asker")
        heard = self.listen(COMMAND, ODOMETRY, DIAGNOSTICS, by=self.asker)
        self.commands, self.states, self.diagnostics = heard.values()

    def add_all(self, speed=5.0, **controller):
        """The three nodes in simulated time, at this speed; None for the wall's time."""
        follow = {"use_sim_time": True} if speed else {}
        drive = {"publish_clock": True, "speed": speed} if speed else {}
        flown = self.configuration
        self.target = self.add(TargetPublisher, **asdict(flown.target), **follow)
        self.simulator = self.add(UavSimulator, **{**asdict(flown.simulator), **drive})
        self.controller = self.add(
            NmpcController, **{**asdict(flown.controller), **controller, **follow}
        )

    def fly(self, seconds):
        """Spin until so much simulated time has passed in [s]."""
        end = self.simulator._now + seconds * 1e9
        assert self.spin(lambda: self.simulator._now >= end)

    def ask(self, kind, service, node="nmpc_controller", **request):
        client = self.asker.create_client(kind, f"{node}/{service}")
        assert self.spin(client.service_is_ready)
        future = client.call_async(kind.Request(**request))
        assert self.spin(future.done)
        self.asker.destroy_client(client)
        return future.result()

    def change(self, *transitions):
        """Whether the controller goes through transitions, as ``configure``."""
        return all(
            self.ask(
                ChangeState,
                "change_state",
                transition=Transition(id=getattr(Transition, f"TRANSITION_{name.upper()}")),
            ).success
            for name in transitions
        )

    def state(self, node="nmpc_controller"):
        """Of the controller's lifecycle, in its word."""
        return self.ask(GetState, "get_state", node).current_state.label

    def set(self, node="nmpc_controller", **values):
        """Why parameters are refused, "" if they are accepted."""
        wanted = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        result = self.ask(
            SetParametersAtomically, "set_parameters_atomically", node, parameters=wanted
        ).result
        return "" if result.successful else result.reason or "no reason"

    def commanded(self, count=10, limit=PATIENCE):
        """Whether commands come from now on."""
        before = len(self.commands)
        return self.spin(lambda: len(self.commands) >= before + count, limit)

    def told(self, node="nmpc_controller"):
        """The latest diagnostics of the controller, or of another node: message and values."""
        status = self.says(node)[-1]
        return status.message, {value.key: value.value for value in status.values}

    def tells(self, words, node="nmpc_controller"):
        """Whether a node comes to say so."""
        return self.spin(lambda: words in self.told(node)[0])

    def says(self, node="nmpc_controller"):
        """All that a node has said in diagnostics, oldest first."""
        return [s for message in self.diagnostics for s in message.status if node in s.name]

    def inputs(self):
        return np.array([plan_from_command(message)[0][0] for message in self.commands])
