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

"""Messages to arrays and back: state with its noise, air velocity, target, commands.

Reading needs no ROS: messages of a bag, decoded by another library, will do.

Jazzy's Python messages do not check what is put into a float field, hence ``float()`` on every
scalar; NaN would pass, hence the checks on everything that comes in.

As nav_msgs defines it, the covariance of an odometry's pose is about the axes of ``map``, in the
order x, y, z and rotations about x, y, z; that of the twist is about those of ``base_link``. A
heading turns about the axis up. A path angle turns about the horizontal axis to the left of the
heading, so its variance spreads over the rotations about x and y. A covariance of zeros is unknown,
by ROS convention, and so is each of its parts that makes no sense
(:mod:`~uav_tracking_mpc.estimation.measurement`). What it says between axes counts for the velocity
alone, which is turned to ``map``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.frames import (
    bank_from_quaternion,
    body_rates,
    course_from_quaternion,
    course_rates,
    pitch_rate_from_path_angle_rate,
    quaternion_from_course,
    rotation_from_course,
    rotation_from_quaternion,
)
from uav_tracking_mpc.estimation.measurement import SILENT, Measurement, SensorNoise, makes_sense
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    FRAMES,
    ODOMETRY,
    POSITION_LIMIT,
    RATE_LIMIT,
    SPEED_LIMIT,
    TARGET,
    TARGET_ODOMETRY,
    FrameNames,
    MessageError,
    Topic,
    check_frame,
    check_header,
    finite_vector,
)

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from geometry_msgs.msg import Point, PointStamped, Quaternion, TwistStamped, Vector3
    from nav_msgs.msg import Odometry
    from trajectory_msgs.msg import MultiDOFJointTrajectory

VARIANCE_LIMIT = 1e8  # m^2 or m^2/s^2, beyond which it says nothing
ROUNDING = 1e-9  # -, rounding: share of the greatest variance by which another may be negative
VARIANCES = slice(0, 15, 7)  # of x, y, z among the 36 entries
BLOCK = (slice(0, 3), slice(6, 9), slice(12, 15))  # rows of x, y, z among them
HEADING = 35  # index of the rotation about the axis up
WINGS_LEVEL = 1e-6  # rad, tolerance: a source that never sends more knows no bank
TILT = (21, 22, 27, 28)  # indices of the rotations about x and y


def set_noise(message: Odometry, noise: SensorNoise, rotation: NDArray[np.float64]) -> None:
    """Fill the covariances of an Odometry message.

    Args:
        noise: Of the measurement; an unknown part gets zeros.
        rotation: From ``base_link`` to ``map`` at the measurement, shape (3, 3).
    """
    pose, twist = message.pose.covariance, message.twist.covariance
    if noise is SILENT:
        pose[:], twist[:] = 0.0, 0.0
        return
    pose[VARIANCES] = np.square(noise.position)
    left, variance = rotation[:2, 1], noise.path_angle**2
    pose[list(TILT)] = variance * np.outer(left, left).ravel()
    pose[HEADING] = noise.heading**2
    block = (rotation.T * np.square(noise.velocity)) @ rotation
    for row, values in zip(BLOCK, block, strict=True):
        twist[row] = values


def noise_from_odometry(message: Odometry, rotation: NDArray[np.float64]) -> SensorNoise:
    """Noise as the covariances of an Odometry message tell it; what makes no sense is unknown.

    Args:
        message: As in ``uav/odometry``.
        rotation: From ``base_link`` to ``map`` at the measurement, shape (3, 3).
    """
    # Floats, not arrays: so few numbers are faster by themselves, and this is the hot path.
    pose, twist = message.pose.covariance.tolist(), message.twist.covariance.tolist()
    if not (any(pose) or any(twist)):
        return SILENT
    axes = rotation.tolist()
    (east, _, _), (north, _, _), _ = axes
    tilts = [pose[index] for index in TILT]
    velocity: Sequence[float] = SILENT.velocity
    if makes_sense(twist[VARIANCES]):
        block = [twist[row] for row in BLOCK]
        velocity = [_quadratic(block, axis) for axis in axes]
    tilt = _along(tilts, -north, east)
    told = SensorNoise.told(pose[VARIANCES], velocity, pose[HEADING], tilt)
    return SILENT if told == SILENT else told


def _quadratic(matrix: list[list[float]], axis: list[float]) -> float:
    """Variance along an axis of a covariance, both of three."""
    x, y, z = axis
    return sum(a * (b * x + c * y + d * z) for a, (b, c, d) in zip(axis, matrix, strict=True))


def _along(tilts: list[float], x: float, y: float) -> float:
    """Variance of the rotation about a horizontal axis (x, y) of any length."""
    xx, xy, yx, yy = tilts
    squared = x * x + y * y
    return (x * x * xx + x * y * (xy + yx) + y * y * yy) / squared if squared > 0.0 else 0.0


def nanoseconds(stamp: Time) -> int:
    """A stamp as one integer, in [ns].

    Args:
        stamp: As in a header.
    """
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def set_stamp(stamp: Time, value: int) -> None:
    """Write nanoseconds into a stamp.

    Args:
        stamp: Changed in place.
        value: In [ns].
    """
    stamp.sec, stamp.nanosec = divmod(int(value), 1_000_000_000)


def set_header(message: Any, stamp: int, frame: str) -> None:
    """Write stamp and frame of a message.

    Args:
        stamp: In [ns].
    """
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = frame


def set_odometry(
    message: Odometry,
    stamp: int,
    state: NDArray[np.float64],
    rates: NDArray[np.float64],
    ground_velocity: NDArray[np.float64] | None = None,
    frames: FrameNames = FRAMES,
) -> None:
    """Fill an Odometry message.

    Args:
        stamp: Time of the state in [ns].
        state: (x, y, z, psi, chi, v), shape (6,).
        rates: (u_psi, u_chi, u_v) flown at the time, shape (3,).
        ground_velocity: In ``map``, shape (3,), in [m/s]; None in still air.
    """
    set_header(message, stamp, frames.map)
    message.child_frame_id = frames.base
    set_vector(message.pose.pose.position, state[:3])
    _, _, _, heading, path_angle, speed = state.tolist()
    set_orientation(message.pose.pose.orientation, heading, path_angle)
    set_vector(
        message.twist.twist.linear,
        (speed, 0.0, 0.0)
        if ground_velocity is None
        else rotation_from_course(heading, path_angle).T @ ground_velocity,
    )
    set_vector(message.twist.twist.angular, body_rates(path_angle, rates))


def set_measurement(
    message: Odometry, stamp: int, seen: Measurement, frames: FrameNames = FRAMES
) -> None:
    """Fill an Odometry message with what was measured.

    Args:
        stamp: Time of the measurement in [ns].
        seen: Of the aircraft.
    """
    rates = np.array([seen.turn_rate, seen.path_angle_rate, 0.0])
    state = seen.state(math.nan if seen.airspeed is None else seen.airspeed)
    set_odometry(message, stamp, state, rates, seen.ground_velocity, frames)
    rotation = rotation_from_course(seen.heading, seen.path_angle)
    if seen.bank is not None:
        rotation = rotation @ _roll(message, seen.bank)
    set_noise(message, seen.noise, rotation)


def _roll(message: Odometry, bank: float) -> NDArray[np.float64]:
    """Bank the body of an Odometry message whose wings are level; the rotation, shape (3, 3)."""
    q, twist = message.pose.pose.orientation, message.twist.twist
    s, c = math.sin(0.5 * bank), math.cos(0.5 * bank)
    q.x, q.y, q.z, q.w = c * q.x + s * q.w, c * q.y + s * q.z, c * q.z - s * q.y, c * q.w - s * q.x
    sine, cosine = math.sin(bank), math.cos(bank)
    rolled = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    for vector in (twist.linear, twist.angular):
        set_vector(vector, rolled.T @ [vector.x, vector.y, vector.z])
    return rolled


def set_air_velocity(
    message: TwistStamped, stamp: int, speed: float, frames: FrameNames = FRAMES
) -> None:
    """Fill the velocity through the air: along the body's x axis.

    Args:
        stamp: When it was measured in [ns].
        speed: Airspeed v in [m/s].
    """
    set_header(message, stamp, frames.base)
    set_vector(message.twist.linear, (speed, 0.0, 0.0))


def set_point(
    message: PointStamped, stamp: int, position: NDArray[np.float64], frames: FrameNames = FRAMES
) -> None:
    """Fill a stamped point in ``map``.

    Args:
        stamp: When it was measured in [ns].
        position: Shape (3,), in [m].
    """
    set_header(message, stamp, frames.map)
    set_vector(message.point, position)


def measurement_from_odometry(
    message: Odometry, stamp: float = 0.0, frames: FrameNames = FRAMES
) -> Measurement:
    """Measurement of an Odometry message; wings that are level tell no bank, as of a point mass.

    Args:
        message: As in ``uav/odometry``.
        stamp: Its time by whatever clock the measurement is to have, in [s].

    Raises:
        MessageError: Wrong frame, no time, not finite, absurd, or no unit quaternion.
    """
    check_header(ODOMETRY, message.header, frames.map)
    check_frame(ODOMETRY, "child_frame_id", message.child_frame_id, frames.base)
    pose, twist = message.pose.pose, message.twist.twist
    position = finite_vector(ODOMETRY, "pose.position", pose.position, POSITION_LIMIT)
    ground = finite_vector(ODOMETRY, "twist.linear", twist.linear, SPEED_LIMIT)
    angular = finite_vector(ODOMETRY, "twist.angular", twist.angular, RATE_LIMIT)
    q = pose.orientation
    directions = _course(ODOMETRY, q)
    rotation = rotation_from_quaternion(q.x, q.y, q.z, q.w)
    bank = bank_from_quaternion(q.x, q.y, q.z, q.w)
    return Measurement(
        stamp,
        position,
        rotation @ ground,
        *directions,
        *course_rates(rotation, angular),
        noise=noise_from_odometry(message, rotation),
        bank=bank if abs(bank) > WINGS_LEVEL else None,
    )


def _course(topic: Topic, q: Quaternion) -> tuple[float, float]:
    """Heading and path angle in [rad] of an orientation of a topic."""
    try:
        return course_from_quaternion(q.x, q.y, q.z, q.w)
    except (ValueError, OverflowError) as error:
        raise MessageError(f"{topic.name}: pose.orientation: {error}") from error


def air_velocity_from_twist(
    message: TwistStamped, frames: FrameNames = FRAMES
) -> NDArray[np.float64]:
    """Velocity through the air in ``base_link``, shape (3,), in [m/s].

    Args:
        message: As in ``uav/air_velocity``.

    Raises:
        MessageError: Wrong frame, no time, not finite, or absurd.
    """
    check_header(AIR_VELOCITY, message.header, frames.base)
    return finite_vector(AIR_VELOCITY, "twist.linear", message.twist.linear, SPEED_LIMIT)


def position_from_point(
    message: PointStamped, frames: FrameNames = FRAMES, topic: Topic = TARGET
) -> NDArray[np.float64]:
    """Position, shape (3,), in [m].

    Args:
        message: As in ``target/position`` or ``target/goal``, whose stamp may be 0.
        topic: From which it came.

    Raises:
        MessageError: Wrong frame, no time, not finite, or absurd.
    """
    check_header(topic, message.header, frames.map)
    return finite_vector(topic, "point", message.point, POSITION_LIMIT)


def set_command(
    message: MultiDOFJointTrajectory,
    stamp: int,
    plan: NDArray[np.float64],
    step: float,
    frames: FrameNames = FRAMES,
) -> None:
    """Fill a command: the inputs now and the plan after them.

    Args:
        stamp: Time at which the plan begins in [ns].
        plan: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3).
        step: T_s in [s].
        frames: Of the message: that of its header, and the joint's name.
    """
    from geometry_msgs.msg import Twist
    from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

    set_header(message, stamp, frames.map)
    message.joint_names, message.points = [frames.base], []
    for index, (turn_rate, path_angle_rate, acceleration) in enumerate(plan.tolist()):
        point = MultiDOFJointTrajectoryPoint(velocities=[Twist()], accelerations=[Twist()])
        set_stamp(point.time_from_start, round(index * step * 1e9))
        angular = point.velocities[0].angular
        angular.y, angular.z = pitch_rate_from_path_angle_rate(path_angle_rate), turn_rate
        point.accelerations[0].linear.x = acceleration
        message.points.append(point)


def plan_from_command(
    message: MultiDOFJointTrajectory, frames: FrameNames = FRAMES
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Plan of a command.

    Args:
        message: As in ``uav/command``.

    Returns:
        Inputs (u_psi, u_chi, u_v), shape (n, 3), and the times from the stamp at which each
        begins, shape (n,), in [s].

    Raises:
        MessageError: Wrong frame or joint, no time, no points, a point without rates or
            accelerations, values that are not finite.
    """
    check_header(COMMAND, message.header, frames.map)
    if frames.base and list(message.joint_names) != [frames.base]:
        raise MessageError(
            f"uav/command: joint_names is {list(message.joint_names)}, must be ['{frames.base}']"
        )
    if not message.points:
        raise MessageError("uav/command: points is empty, must hold at least the command now")
    plan, starts = np.empty((len(message.points), 3)), np.empty(len(message.points))
    for index, point in enumerate(message.points):
        if not (point.velocities and point.accelerations):
            raise MessageError(
                f"uav/command: points[{index}] lacks velocities[0] or accelerations[0]"
            )
        angular = point.velocities[0].angular
        path_angle_rate = pitch_rate_from_path_angle_rate(angular.y)
        plan[index] = angular.z, path_angle_rate, point.accelerations[0].linear.x
        starts[index] = nanoseconds(point.time_from_start) * 1e-9
    if not np.all(np.isfinite(plan)):
        raise MessageError(f"uav/command: plan is {plan.tolist()}, must be finite")
    return plan, starts


class TargetMeasurement(NamedTuple):
    """What :meth:`Controller.see_target` takes, but for the stamp.

    Attributes:
        position: In ``map``, shape (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s]; None if it is not known.
        covariance: Of position and velocity, shape (6, 6), in SI units, zeros for what is not
            known; None if neither is known.
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None
    covariance: NDArray[np.float64] | None


def target_from_odometry(message: Odometry, frames: FrameNames = FRAMES) -> TargetMeasurement:
    """Measurement of the target.

    Args:
        message: As in ``target/odometry``.

    Raises:
        MessageError: Wrong frame, no time, not finite, absurd, or no unit quaternion where the
            velocity is to be rotated.
    """
    check_header(TARGET_ODOMETRY, message.header, frames.map)
    place = message.pose.pose.position
    position = finite_vector(TARGET_ODOMETRY, "pose.position", place, POSITION_LIMIT)
    spread = _covariance(message.pose.covariance)
    velocity, velocity_spread = _velocity(message)
    if spread is None and velocity_spread is None:
        return TargetMeasurement(position, velocity, None)
    covariance = np.zeros((6, 6))
    if spread is not None:
        covariance[:3, :3] = spread
    if velocity_spread is not None:
        covariance[3:, 3:] = velocity_spread
    return TargetMeasurement(position, velocity, covariance)


def _velocity(message: Odometry) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
    """Velocity in ``map`` in [m/s] and its covariance; None for what is not known."""
    twist = message.twist
    velocity = finite_vector(TARGET_ODOMETRY, "twist.linear", twist.twist.linear, SPEED_LIMIT)
    spread = _covariance(twist.covariance)
    if twist.covariance[0] < 0.0 or (spread is None and not velocity.any()):
        return None, None
    if message.child_frame_id in ("", message.header.frame_id):
        return velocity, spread
    q = message.pose.pose.orientation
    _course(TARGET_ODOMETRY, q)
    rotation = rotation_from_quaternion(q.x, q.y, q.z, q.w)
    if spread is not None:
        spread = rotation @ spread @ rotation.T
    return rotation @ velocity, spread


def _covariance(entries: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The first three rows and columns of a covariance of six; None if it says nothing."""
    matrix = np.array(entries, dtype=float).reshape(6, 6)[:3, :3]
    told = np.isfinite(matrix).all() and matrix[0, 0] > 0.0
    if not told or max(matrix[0, 0], matrix[1, 1]) > VARIANCE_LIMIT:  # a height's may be anything
        return None
    matrix = 0.5 * (matrix + matrix.T)
    variances = np.linalg.eigvalsh(matrix)
    return matrix if variances[0] >= -ROUNDING * variances[-1] else None


def set_truth(
    message: Odometry,
    stamp: int,
    position: NDArray[np.float64],
    velocity: NDArray[np.float64],
    frames: FrameNames = FRAMES,
) -> None:
    """Fill ``target/truth``, or ``target/odometry`` of a tracker that tells the velocity.

    Args:
        stamp: In [ns].
        position: In ``map``, shape (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s].
    """
    set_header(message, stamp, frames.map)
    message.child_frame_id = frames.map
    set_vector(message.pose.pose.position, position)
    set_vector(message.twist.twist.linear, velocity)


def truth_from_odometry(message: Odometry) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """What ``target/truth`` says.

    Args:
        message: As :func:`set_truth` fills it.

    Returns:
        Stamp in [ns]; position and velocity in ``map``, shape (3,), in [m] and [m/s].
    """
    place, speed = message.pose.pose.position, message.twist.twist.linear
    position, velocity = (np.array([part.x, part.y, part.z]) for part in (place, speed))
    return nanoseconds(message.header.stamp), position, velocity


def set_vector(message: Point | Vector3, values: Sequence[float] | NDArray[np.float64]) -> None:
    """Fill a vector.

    Args:
        values: Shape (3,), in the unit of the field.
    """
    message.x, message.y, message.z = float(values[0]), float(values[1]), float(values[2])


def set_orientation(message: Quaternion, heading: float, path_angle: float) -> None:
    """Fill the orientation of ``base_link`` in ``map``, wings level.

    Args:
        heading: psi in [rad].
        path_angle: chi in [rad].
    """
    message.x, message.y, message.z, message.w = quaternion_from_course(
        float(heading), float(path_angle)
    )
