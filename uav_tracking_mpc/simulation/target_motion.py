"""How the simulated target moves: it stands, runs straight, circles, or visits waypoints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.parameters import ParameterError, parameter

MOTIONS = ("stationary", "line", "circle", "waypoints")


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
    rate: float = parameter(
        10.0, "How often the position is published.", unit="Hz", lower=0.1, upper=1000.0
    )
    noise: float = parameter(
        0.0,
        "Standard deviation of the published position, each axis.",
        unit="m",
        lower=0.0,
        upper=1e3,
    )
    seed: int = parameter(0, "Seed of the noise.", lower=0, upper=2**31 - 1)

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
    if parameters.motion == "line":
        return origin + travelled * np.array(
            [np.cos(parameters.heading), np.sin(parameters.heading), 0.0]
        )
    if parameters.motion == "circle":
        azimuth = parameters.heading + travelled / parameters.radius
        return origin + parameters.radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    if parameters.motion == "waypoints":
        corners = np.array(parameters.waypoints).reshape(-1, 3)
        corners = np.vstack([corners, corners[:1]])
        distance = np.concatenate(
            [[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))]
        )
        along = travelled % distance[-1]
        return np.array([np.interp(along, distance, axis) for axis in corners.T])
    return origin
