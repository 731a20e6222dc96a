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

"""The topics that faults strike, on both sides of the relay, and what the relay is told."""

from __future__ import annotations

from dataclasses import replace

from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET, Topic

STREAMS = (ODOMETRY, AIR_VELOCITY, TARGET, COMMAND, CLOCK)
QUEUE = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
ORDERS = Topic(
    "torture/fault",
    String,
    QUEUE,
    "campaign",
    "A fault as JSON: reference, fault, seed, seconds, speed, reach",
)


def raw(topic: Topic) -> Topic:
    """The topic before the relay: what its sender truly sent.

    Args:
        topic: As it is after the relay.
    """
    return replace(topic, name=f"/raw{topic.name}" if topic is CLOCK else f"raw/{topic.name}")
