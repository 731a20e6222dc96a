"""Every topic of the package: name, type, quality of service, who sends it and what it means."""

from __future__ import annotations

from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, TwistStamped
from nav_msgs.msg import Odometry, Path
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from trajectory_msgs.msg import MultiDOFJointTrajectory
from visualization_msgs.msg import MarkerArray

LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
MANY_SENDERS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


@dataclass(frozen=True)
class Topic:
    """One topic.

    Attributes:
        name: Relative, so that a namespace moves it; absolute where ROS fixes it.
        type: Message class.
        qos: Offered and asked for.
        sender: Node that publishes it.
        meaning: For people.
        optional: Whether a flight may go without it.
    """

    name: str
    type: type
    qos: QoSProfile
    sender: str
    meaning: str
    optional: bool = False

    @property
    def type_name(self) -> str:
        """Type as ROS writes it, such as ``nav_msgs/msg/Odometry``."""
        package = self.type.__module__.split(".", 1)[0]
        return f"{package}/msg/{self.type.__name__}"


ODOMETRY = Topic(
    "uav/odometry",
    Odometry,
    LATEST,
    "uav_simulator or autopilot_link",
    "Pose in `map`; twist in `base_link`: ground velocity and body rates.",
)
AIR_VELOCITY = Topic(
    "uav/air_velocity",
    TwistStamped,
    LATEST,
    "uav_simulator or autopilot_link",
    "Velocity through the air, in `base_link`.",
)
TARGET = Topic(
    "target/position",
    PointStamped,
    LATEST,
    "target_publisher, or autopilot_link with `target_system`",
    "Measured position of the target in `map`, noisy, at any rate.",
)
TARGET_ODOMETRY = Topic(
    "target/odometry",
    Odometry,
    LATEST,
    "a tracker, or autopilot_link with `target_system`",
    "Instead of `target/position`: pose in `map`; twist in `child_frame_id`, which is the target's "
    "own frame by its orientation, or `map` if empty; covariances count where given.",
    optional=True,
)
COMMAND = Topic(
    "uav/command",
    MultiDOFJointTrajectory,
    LATEST,
    "nmpc_controller",
    "points[0]: the command now; the rest: the plan, time_from_start = k T_s. "
    "velocities[0].angular.z = yaw rate, .y = FLU pitch rate (minus the path-angle rate), "
    "accelerations[0].linear.x = acceleration.",
)
ORBIT = Topic(
    "uav/orbit",
    JointState,
    LATEST,
    "nmpc_controller",
    "What the command leads to, for autopilots that hold altitude and airspeed themselves or "
    "loiter when commands end. Names east, north, up, radius, airspeed: centre of the circle in "
    "`map` (up: altitude of the circle itself), horizontal radius (negative clockwise), airspeed; "
    "velocity: that of the centre.",
)
ENGAGED = Topic(
    "uav/engaged",
    Bool,
    LATEST,
    "autopilot_link",
    "Whether the aircraft flies the commands: 1 Hz and on change. Without it they count as flown.",
    optional=True,
)
PREDICTED_PATH = Topic(
    "uav/predicted_path", Path, LATEST, "nmpc_controller", "The plan in `map`, at most 5 Hz."
)
MARKERS = Topic(
    "uav/markers",
    MarkerArray,
    LATEST,
    "nmpc_controller",
    "Target, desired orbit, plan and aircraft, at most 5 Hz.",
)
DIAGNOSTICS = Topic(
    "/diagnostics", DiagnosticArray, MANY_SENDERS, "every node", "1 Hz and on change."
)
CLOCK = Topic(
    "/clock", Clock, LATEST, "uav_simulator", "Simulated time, with `publish_clock` only."
)
TRACKING = {
    name: Topic(f"uav/tracking/{name}", Float64, LATEST, "nmpc_controller", meaning)
    for name, meaning in {
        "range_error": "r - r_d [m].",
        "bearing_error": "theta - theta_d, wrapped [rad].",
        "altitude_error": "z - z_d [m].",
        "pitch_error": "chi, whose reference is 0 [rad].",
        "speed_error": "v - v_d [m/s].",
        "cost": "Optimal cost V_N.",
        "solve_time": "Wall time of the solve [s].",
    }.items()
}
ALL = (
    ODOMETRY,
    AIR_VELOCITY,
    TARGET,
    TARGET_ODOMETRY,
    COMMAND,
    ORBIT,
    ENGAGED,
    PREDICTED_PATH,
    MARKERS,
    *TRACKING.values(),
    DIAGNOSTICS,
    CLOCK,
)
