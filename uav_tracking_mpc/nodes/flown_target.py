"""Where the target of a recorded flight was: by its motion, or by what it said itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of


class FlownTarget(NamedTuple):
    """A target at the times of a flight's states.

    Attributes:
        position: In ``map``, shape (n, 3), in [m].
        velocity: In ``map``, shape (n, 3), in [m/s].
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]


def simulated_target(
    parameters: TargetParameters, began: int, stamps: Sequence[int]
) -> FlownTarget:
    """The true motion of a target that was simulated.

    Args:
        parameters: Of its motion.
        began: When the motion began in [ns].
        stamps: Times asked for in [ns].
    """
    motion, times = motion_of(parameters), [(stamp - began) * 1e-9 for stamp in stamps]
    return FlownTarget(
        np.array([motion.position(time) for time in times]).reshape(-1, 3),
        np.array([motion.velocity(time) for time in times]).reshape(-1, 3),
    )


def sighted_target(
    sightings: Sequence[tuple[int, NDArray[np.float64]]], stamps: Sequence[int]
) -> FlownTarget:
    """The motion of a target that told its positions, interpolated.

    Args:
        sightings: Stamps in [ns] and positions, shape (3,), in [m].
        stamps: Times asked for in [ns].

    Raises:
        ValueError: There is no sighting.
    """
    if not sightings:
        raise ValueError("the bag holds no position of the target")
    first = sightings[0][0]  # differences keep their nanoseconds as floats
    seen = {(stamp - first) * 1e-9: position for stamp, position in sightings}
    seen = dict(sorted(seen.items()))
    times, places = np.array(list(seen)), np.array(list(seen.values()))
    wanted = np.array([(stamp - first) * 1e-9 for stamp in stamps])
    speeds = np.gradient(places, times, axis=0) if len(times) > 1 else np.zeros_like(places)
    return FlownTarget(
        np.column_stack([np.interp(wanted, times, axis) for axis in places.T]),
        np.column_stack([np.interp(wanted, times, axis) for axis in speeds.T]),
    )
