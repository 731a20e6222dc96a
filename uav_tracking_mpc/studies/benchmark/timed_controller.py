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

"""The controller's node in a process that also answers the echo."""

from __future__ import annotations

import sys

from rclpy.node import Node

from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.studies.benchmark.echo import EchoAnswer


def _timed() -> Node:
    node = NmpcController()
    EchoAnswer(node, node.parameters.horizon, node.parameters.horizon_step)
    return node


if __name__ == "__main__":
    sys.exit(run("nmpc_controller", _timed))
