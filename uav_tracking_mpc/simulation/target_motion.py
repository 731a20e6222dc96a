"""How the simulated target moves, as a function of time alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.parameters.specification import ParameterError, parameter

MOTIONS = ("stationary", "line", "circle", "waypoints", "stop_and_go", "jump")


@dataclass(frozen=True)
class TargetParameters:
    """Motion and measurement of the target.

    Raises:
        ParameterError: Waypoints are asked for and there are fewer than two different ones.
    """

    motion: str = parameter("stationary", "How the target moves.", choices=MOTIONS)
    position: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Where it stands or starts in map; for a circle, its centre.",
        unit="m",
        size=3,
        lower=-1e6,
        upper=1e6,
    )
    speed: float = parameter(
        0.0, "Speed along its path; ignored when stationary.", unit="m/s", lower=0.0, upper=100.0
    )
    heading: float = parameter(
        0.0,
        "Direction of a straight run, or azimuth of a circle's start, from East.",
        unit="rad",
        lower=-2.0 * np.pi,
        upper=2.0 * np.pi,
    )
    radius: float = parameter(100.0, "Radius of a circle.", unit="m", lower=0.1, upper=1e5)
    waypoints: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 100.0, 0.0, 0.0),
        "x, y, z of one point after the other, visited in turn and from the start again.",
        unit="m",
        multiple=3,
        lower=-1e6,
        upper=1e6,
    )
    drive_time: float = parameter(
        20.0,
        "How long stop_and_go drives at a time, straight on.",
        unit="s",
        lower=0.1,
        upper=1e5,
    )
    stand_time: float = parameter(
        20.0, "How long stop_and_go stands in between.", unit="s", lower=0.1, upper=1e5
    )
    jump_time: float = parameter(
        60.0,
        "When jump, otherwise a straight run, is somewhere else at once.",
        unit="s",
        lower=0.0,
        upper=1e6,
    )
    jump_offset: tuple[float, ...] = parameter(
        (100.0, 0.0, 0.0), "By how much it is moved.", unit="m", size=3, lower=-1e6, upper=1e6
    )
    rate: float = parameter(
        10.0, "How often the position is measured.", unit="Hz", lower=0.1, upper=1000.0
    )
    noise: float = parameter(
        0.0,
        "Standard deviation of the measured position, each axis.",
        unit="m",
        lower=0.0,
        upper=1e3,
    )
    dropout: float = parameter(
        0.0, "Probability with which a measurement is lost.", lower=0.0, upper=1.0
    )
    delay: float = parameter(
        0.0,
        "How late a measurement is published; its stamp is the time of measuring.",
        unit="s",
        lower=0.0,
        upper=60.0,
    )
    seed: int = parameter(0, "Seed of noise and dropouts.", lower=0, upper=2**31 - 1)

    def __post_init__(self) -> None:
        """Check that the waypoints make a path."""
        if self.motion == "waypoints":
            points = np.array(self.waypoints).reshape(-1, 3)
            if len(np.unique(points, axis=0)) < 2:
                raise ParameterError(
                    f"parameter 'waypoints' is {list(self.waypoints)}, must hold at least two "
                    "different points"
                )


def target_position(parameters: TargetParameters, time: float) -> NDArray[np.float64]:
    """True position of the target in ``map``, shape (3,), in [m].

    Args:
        parameters: How it moves.
        time: Since its start in [s].
    """
    origin = np.array(parameters.position)
    travelled = parameters.speed * time
    if parameters.motion in ("line", "stop_and_go", "jump"):
        if parameters.motion == "stop_and_go":
            travelled = parameters.speed * _time_driven(parameters, time)
        elif parameters.motion == "jump" and time >= parameters.jump_time:
            origin = origin + parameters.jump_offset
        return origin + travelled * _direction(parameters)
    if parameters.motion == "circle":
        azimuth = parameters.heading + travelled / parameters.radius
        return origin + parameters.radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    if parameters.motion == "waypoints":
        corners, distance = _path(parameters)
        along = travelled % distance[-1]
        return np.array([np.interp(along, distance, axis) for axis in corners.T])
    return origin


def target_velocity(parameters: TargetParameters, time: float) -> NDArray[np.float64]:
    """True velocity of the target in ``map``, shape (3,), in [m/s].

    At a corner, a start or a stop it is the velocity after it; a jump has none.

    Args:
        parameters: How it moves.
        time: Since its start in [s].
    """
    if parameters.motion in ("line", "jump"):
        return parameters.speed * _direction(parameters)
    if parameters.motion == "stop_and_go":
        drives = time % (parameters.drive_time + parameters.stand_time) < parameters.drive_time
        return parameters.speed * _direction(parameters) if drives else np.zeros(3)
    if parameters.motion == "circle":
        azimuth = parameters.heading + parameters.speed * time / parameters.radius
        return parameters.speed * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    if parameters.motion == "waypoints":
        corners, distance = _path(parameters)
        along = parameters.speed * time % distance[-1]
        segment = int(np.searchsorted(distance, along, side="right")) - 1
        chord = corners[segment + 1] - corners[segment]
        return parameters.speed * chord / (distance[segment + 1] - distance[segment])
    return np.zeros(3)


def _direction(parameters: TargetParameters) -> NDArray[np.float64]:
    return np.array([np.cos(parameters.heading), np.sin(parameters.heading), 0.0])


def _time_driven(parameters: TargetParameters, time: float) -> float:
    """How long stop_and_go has driven by ``time`` [s]."""
    rounds, rest = divmod(time, parameters.drive_time + parameters.stand_time)
    return rounds * parameters.drive_time + min(rest, parameters.drive_time)


def _path(parameters: TargetParameters) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Waypoints, shape (n, 3), back to the first, and how far along the path each lies [m]."""
    corners = np.array(parameters.waypoints).reshape(-1, 3)
    corners = np.vstack([corners, corners[:1]])
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    return corners, np.concatenate([[0.0], np.cumsum(lengths)])
