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

"""Connect ``nmpc_controller`` to an odometry and an autopilot that know nothing of it.

The odometry may be best effort, late, and in frames of other names. The autopilot takes turn rate,
path-angle rate and acceleration, 50 times a second.
"""

import sys

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, plan_from_command
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY
from uav_tracking_mpc.simulation.plan_follower import PlanFollower


class OdometryAdapter(Node):
    """Renames the frames of ``ekf/odometry`` and executes plans on ``autopilot/rates``.

    Args:
        options: Those of rclpy's Node.
    """

    def __init__(self, **options):
        super().__init__("odometry_adapter", **options)
        self._plan = PlanFollower()
        self._state = self.create_publisher(Odometry, ODOMETRY.name, 1)
        self._rates = self.create_publisher(Vector3Stamped, "autopilot/rates", 1)
        best_effort = qos_profile_sensor_data
        self.create_subscription(Odometry, "ekf/odometry", self._on_odometry, best_effort)
        self.create_subscription(COMMAND.type, COMMAND.name, self._on_command, 1)
        self.create_timer(0.02, self._send)  # s, the autopilot's period

    def _on_odometry(self, message):
        """The stamp stays the time of measurement: the controller predicts from there."""
        message.header.frame_id, message.child_frame_id = "map", "base_link"
        self._state.publish(message)

    def _on_command(self, message):
        plan, starts = plan_from_command(message)
        begin = nanoseconds(message.header.stamp) * 1e-9
        self._plan.accept(plan, begin + starts, self.get_clock().now().nanoseconds * 1e-9)

    def _send(self):
        """Send what the plan asks for now; after its end, no turn and no climb."""
        now = self.get_clock().now()
        inputs = self._plan.inputs(now.nanoseconds * 1e-9)
        rates = Vector3Stamped()
        rates.header.stamp = now.to_msg()
        vector = rates.vector
        vector.x, vector.y, vector.z = np.zeros(3) if inputs is None else inputs
        self._rates.publish(rates)


if __name__ == "__main__":
    sys.exit(run("odometry_adapter", OdometryAdapter))
