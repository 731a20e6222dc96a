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
