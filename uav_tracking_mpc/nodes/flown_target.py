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

"""Where the target of a recorded flight was: by its own word, its motion, or as it was seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of

Truth = tuple[int, NDArray[np.float64], NDArray[np.float64]]  # stamp [ns], place [m], speed [m/s]


class FlownTarget(NamedTuple):
    """A target at the times of a flight's states.

    Attributes:
        position: In ``map``, shape (n, 3), in [m].
        velocity: In ``map``, shape (n, 3), in [m/s].
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]


def simulated_target(
    parameters: TargetParameters, began: int, stamps: Sequence[int], truths: Sequence[Truth] = ()
) -> FlownTarget:
    """The true motion of a target that was simulated: as it told, for it may have been steered.

    Args:
        parameters: Of its motion at the start, which counts where it told nothing.
        began: When the motion began in [ns].
        stamps: Times asked for in [ns].
        truths: What it told.
    """
    if truths:
        return _told_target(truths, stamps)
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


def _told_target(told: Sequence[Truth], stamps: Sequence[int]) -> FlownTarget:
    """Cubic Hermite interpolation; before the first and after the last it moves straight on."""
    first = told[0][0]  # differences keep their nanoseconds as floats
    known = {(stamp - first) * 1e-9: motion for stamp, *motion in told}
    known = dict(sorted(known.items()))
    times = np.array(list(known))
    places, velocities = np.moveaxis(np.array(list(known.values())), 1, 0)
    wanted = np.array([(stamp - first) * 1e-9 for stamp in stamps])
    inside = np.clip(wanted, times[0], times[-1])
    if len(times) == 1:
        position = np.tile(places[0], (len(wanted), 1))
        velocity = np.tile(velocities[0], (len(wanted), 1))
    else:
        curve = CubicHermiteSpline(times, places, velocities)
        position, velocity = curve(inside), curve(inside, 1)
    return FlownTarget(position + velocity * (wanted - inside)[:, np.newaxis], velocity)
