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

"""Every topic of the package: name, type, quality of service, who sends it and what it means.

And what may stand in its messages: names of frames, stamps, and numbers that can be flown by.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.frame_parameters import NAMESPACE, FrameParameters

if TYPE_CHECKING:
    from geometry_msgs.msg import Point, Vector3
    from rclpy.node import Node
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Header


POSITION_LIMIT = 1e7  # m; what lies beyond is no position on this earth
SPEED_LIMIT = 1e3  # m/s, no aircraft or target is faster
RATE_LIMIT = 1e2  # rad/s, no aircraft turns faster


@dataclass(frozen=True)
class Quality:
    """Quality of service of a publisher.

    Attributes:
        depth: How many messages wait at most.
        reliable: Whether what is lost is sent again.
        kept: Whether who comes later hears the last ones, too.
        lifespan: After which a message is not sent any more in [s]; 0 for none.
    """

    depth: int = 1
    reliable: bool = True
    kept: bool = False
    lifespan: int = 0

    @property
    def profile(self) -> QoSProfile:
        """As rclpy takes it."""
        from rclpy.duration import Duration
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

        reliability, durability = ReliabilityPolicy, DurabilityPolicy
        return QoSProfile(
            depth=self.depth,
            reliability=reliability.RELIABLE if self.reliable else reliability.BEST_EFFORT,
            durability=durability.TRANSIENT_LOCAL if self.kept else durability.VOLATILE,
            lifespan=Duration(seconds=self.lifespan),
        )


LATEST, SENSED, MANY_SENDERS = Quality(), Quality(reliable=False), Quality(depth=10)
LOG = Quality(depth=1000, kept=True, lifespan=10)  # as rcl publishes it


@dataclass(frozen=True)
class Topic:
    """One topic, as plain data: reading its messages from a bag needs no ROS.

    Attributes:
        name: Relative, so that a namespace moves it; absolute where ROS fixes it.
        type_name: Type as ROS writes it, such as ``nav_msgs/msg/Odometry``.
        quality: Offered by who sends it.
        sender: Node that publishes it.
        meaning: For people.
        optional: Whether a flight may go without it.
        sensed: Whether drivers, which often publish best effort, may be its senders.
    """

    name: str
    type_name: str
    quality: Quality
    sender: str
    meaning: str
    optional: bool = False
    sensed: bool = False

    @property
    def type(self) -> Any:
        """Message class."""
        package, _, name = self.type_name.split("/")
        return getattr(importlib.import_module(f"{package}.msg"), name)

    @property
    def qos(self) -> QoSProfile:
        """Quality of service of who sends it."""
        return self.quality.profile

    @property
    def heard(self) -> QoSProfile:
        """Quality of service that is asked for: what connects with every sender there may be."""
        return (SENSED if self.sensed else self.quality).profile


ODOMETRY = Topic(
    "uav/odometry",
    "nav_msgs/msg/Odometry",
    LATEST,
    "uav_simulator or autopilot_link",
    "Pose in `map`; twist in `base_link`: ground velocity and body rates.",
    sensed=True,
)
AIR_VELOCITY = Topic(
    "uav/air_velocity",
    "geometry_msgs/msg/TwistStamped",
    LATEST,
    "uav_simulator or autopilot_link",
    "Velocity through the air, in `base_link`.",
    sensed=True,
)
TARGET = Topic(
    "target/position",
    "geometry_msgs/msg/PointStamped",
    LATEST,
    "target_publisher, or autopilot_link with `target_system`",
    "Measured position of the target in `map`, noisy, at any rate.",
    sensed=True,
)
TARGET_ODOMETRY = Topic(
    "target/odometry",
    "nav_msgs/msg/Odometry",
    LATEST,
    "a tracker, or autopilot_link with `target_system`",
    "Instead of `target/position`: pose in `map`; twist in `child_frame_id`, which is the target's "
    "own frame by its orientation, or `map` if empty; covariances count where given.",
    optional=True,
    sensed=True,
)
TARGET_GOAL = Topic(
    "target/goal",
    "geometry_msgs/msg/PointStamped",
    LATEST,
    "people",
    "Where the target is to go and stand, in `map`: at its `speed`, or 5 m/s if that is 0.",
    optional=True,
)
TARGET_TRUTH = Topic(
    "target/truth",
    "nav_msgs/msg/Odometry",
    LATEST,
    "target_publisher",
    "Where the target truly is and how it moves, pose and twist in `map`: 20 Hz, for records and "
    "plots. The controller does not listen.",
    optional=True,
)
COMMAND = Topic(
    "uav/command",
    "trajectory_msgs/msg/MultiDOFJointTrajectory",
    LATEST,
    "nmpc_controller",
    "points[0]: the command now; the rest: the plan, time_from_start = k T_s. "
    "velocities[0].angular.z = yaw rate, .y = FLU pitch rate (minus the path-angle rate), "
    "accelerations[0].linear.x = acceleration along the body's x axis: these are flown. For who "
    "flies by places, in `map`: transforms[0] = planned place and attitude with wings level, "
    "velocities[0].linear = planned velocity over ground.",
)
ORBIT = Topic(
    "uav/orbit",
    "sensor_msgs/msg/JointState",
    LATEST,
    "nmpc_controller",
    "What the command leads to, for autopilots that hold altitude and airspeed themselves or "
    "loiter when commands end. Names east, north, up, radius, airspeed: centre of the circle in "
    "`map` (up: altitude of the circle itself), horizontal radius (negative clockwise), airspeed; "
    "velocity: that of the centre.",
)
ENGAGED = Topic(
    "uav/engaged",
    "std_msgs/msg/Bool",
    LATEST,
    "autopilot_link",
    "Whether the aircraft flies the commands: 1 Hz and on change. Without it they count as flown.",
    optional=True,
)
PREDICTED_PATH = Topic(
    "uav/predicted_path",
    "nav_msgs/msg/Path",
    LATEST,
    "nmpc_controller",
    "The plan in `map`, at most 5 Hz.",
)
MARKERS = Topic(
    "uav/markers",
    "visualization_msgs/msg/MarkerArray",
    LATEST,
    "nmpc_controller",
    "Target, desired orbit, plan and aircraft, at most 5 Hz.",
)
DIAGNOSTICS = Topic(
    "/diagnostics",
    "diagnostic_msgs/msg/DiagnosticArray",
    MANY_SENDERS,
    "every node",
    "1 Hz and on change.",
)
ROSOUT = Topic(
    "/rosout",
    "rcl_interfaces/msg/Log",
    LOG,
    "every node",
    "What the nodes log; ROS itself sends it.",
    optional=True,
)
CLOCK = Topic(
    "/clock",
    "rosgraph_msgs/msg/Clock",
    LATEST,
    "uav_simulator",
    "Simulated time, with `publish_clock` only.",
)
TRACKING = {
    name: Topic(f"uav/tracking/{name}", "std_msgs/msg/Float64", LATEST, "nmpc_controller", meaning)
    for name, meaning in {
        "range_error": "r - r_d [m], of the state that is answered, as are the other errors.",
        "bearing_error": "theta - theta_d, wrapped [rad].",
        "altitude_error": "z - z_d [m].",
        "pitch_error": "chi, whose reference is 0 [rad].",
        "speed_error": "v - v_d [m/s].",
        "cost": "Optimal cost V_N.",
        "solve_time": "Wall time of the solve [s].",
    }.items()
}
TRACKING_ERRORS = Topic(
    "uav/tracking_errors",
    "sensor_msgs/msg/JointState",
    LATEST,
    "nmpc_controller",
    "What the controller tracks by in one message, stamped as the state; with each command, once a "
    "target is known. Names (more may follow): range_error, bearing_error, altitude_error, "
    "pitch_error, speed_error as in `uav/tracking/...`; bank (of a coordinated turn, right wing "
    "down [rad]); target_east, target_north, target_up (as estimated, in `map`); target_std (of "
    "each [m]); wind_east, wind_north, wind_up (as estimated, with gust); mode (0 optimal plan, 1 "
    "guidance law, 2 feasible plan, 3 earlier plan, 4 loiter law, 5 wings level); airspeed (as "
    "estimated) and surplus (what the aircraft turns quicker than its bank says [rad/s]), from "
    "which autopilot_link finds the bank. Values in `position`.",
)
# As tf2 offers them; for viewers, and only where ROS has tf2_msgs.
TRANSFORMS, STATIC_TRANSFORMS = (
    Topic(name, "tf2_msgs/msg/TFMessage", quality, ODOMETRY.sender, "Frames for tf2.")
    for name, quality in {"/tf": Quality(depth=100), "/tf_static": Quality(kept=True)}.items()
)
ALL = (
    ODOMETRY,
    AIR_VELOCITY,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_GOAL,
    TARGET_TRUTH,
    COMMAND,
    ORBIT,
    ENGAGED,
    PREDICTED_PATH,
    MARKERS,
    *TRACKING.values(),
    TRACKING_ERRORS,
    DIAGNOSTICS,
    ROSOUT,
    CLOCK,
)


class MessageError(MeasurementError):
    """A message cannot be used; the text names topic, field and value."""


def finite_vector(
    topic: Topic, name: str, message: Point | Vector3, limit: float
) -> NDArray[np.float64]:
    """A vector of a message, shape (3,), in the unit of the field.

    Args:
        topic: From which it came.
        name: Of the field.
        message: The vector.
        limit: Greatest absolute value of a component, in [m], [m/s] or [rad/s] as the field.

    Raises:
        MessageError: A component is not finite or beyond the limit.
    """
    values = [message.x, message.y, message.z]
    for axis, value in zip("xyz", values, strict=True):
        if not abs(value) <= limit:
            raise MessageError(
                f"{topic.name}: {name}.{axis} is {value}, must be finite and within {limit:g}"
            )
    return np.array(values, dtype=float)


def check_header(topic: Topic, header: Header, frame: str) -> None:
    """Check frame and stamp of a message.

    Args:
        topic: From which it came.
        header: Of the message.
        frame: In which it must be; empty for any.

    Raises:
        MessageError: Another frame, or a stamp that is no time.
    """
    check_frame(topic, "header.frame_id", header.frame_id, frame)
    if header.stamp.nanosec >= 1_000_000_000:  # as a time it could lie past the last one there is
        raise MessageError(
            f"{topic.name}: header.stamp.nanosec is {header.stamp.nanosec}, must be below "
            "1000000000"
        )


def check_frame(topic: Topic, name: str, frame: str, expected: str) -> None:
    """Check the name of a frame.

    Args:
        topic: From which it came.
        name: Of the field.
        frame: What stands there.
        expected: What must stand there; empty for any.

    Raises:
        MessageError: Another one.
    """
    if expected and frame != expected:
        raise MessageError(f"{topic.name}: {name} is '{frame}', must be '{expected}'")


class FrameNames(NamedTuple):
    """As they stand in messages.

    Attributes:
        map: Of positions: ENU.
        base: Of the aircraft, FLU, with its prefix.
    """

    map: str = "map"
    base: str = "base_link"


FRAMES = FrameNames()  # where nobody says otherwise
ANY_FRAMES = FrameNames("", "")  # for who only looks: messages are read whatever their frames


def frame_names(node: Node, parameters: FrameParameters) -> FrameNames:
    """The names that a node is told.

    Args:
        node: Whose namespace may be the prefix.
        parameters: With ``map_frame``, ``base_frame`` and ``frame_prefix``.

    Raises:
        ParameterError: A name is none that tf2 takes, or both frames are one.
    """
    prefix = parameters.frame_prefix
    if prefix == NAMESPACE:
        namespace = node.get_namespace().strip("/")
        prefix = f"{namespace}/" if namespace else ""
    elif prefix:
        _check("frame_prefix", prefix)
    names = FrameNames(
        map_frame(parameters.map_frame), prefix + _check("base_frame", parameters.base_frame)
    )
    if names.map == names.base:
        raise ParameterError(
            f"parameter 'base_frame' is '{parameters.base_frame}', must be another frame than "
            f"'map_frame' = '{names.map}'"
        )
    return names


def map_frame(name: str) -> str:
    """The name of the frame of positions, checked.

    Args:
        name: As parameter ``map_frame``.

    Raises:
        ParameterError: It is none that tf2 takes.
    """
    return _check("map_frame", name)


def _check(parameter: str, name: str) -> str:
    if not name or name.startswith("/") or any(letter.isspace() for letter in name):
        raise ParameterError(
            f"parameter '{parameter}' is {name!r}, must be a frame: not empty, without a leading "
            "slash and without blanks"
        )
    return name
