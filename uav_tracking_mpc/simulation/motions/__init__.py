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

"""How simulated targets move.

===============  ==============================================================
``straight``     stands, or runs straight on: always, with stops, turns, a jump
``circuit``      comes round again: a circle, waypoints
``conformance``  whether a motion keeps what the base asks for
===============  ==============================================================

A motion is a subclass of :class:`TargetMotion` with a name. It is found by that name, by an entry
point in the group ``uav_tracking_mpc.simulation.motions``, or as ``path.py:Class``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.parameters.registry import ExtensionError, ExtensionPoint
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import TargetParameters


class TargetMotion(ABC):
    """Where the target is, as a function of time alone.

    Args:
        parameters: Start, speed and figures of the motion.

    Attributes:
        name: By which it is found.
        parameters: As above.
    """

    name: ClassVar[str]

    def __init__(self, parameters: TargetParameters) -> None:
        self.parameters = parameters
        self._start = np.array(parameters.position)

    @classmethod
    def starting(
        cls, parameters: TargetParameters, place: NDArray[np.float64], velocity: NDArray[np.float64]
    ) -> TargetParameters:
        """Parameters of this motion where a target takes it up that is somewhere already.

        A motion whose path lies elsewhere answers where it is joined: the target drives there.

        Args:
            parameters: That are asked for.
            place: Where the target is in ``map``, shape (3,), in [m].
            velocity: Of the target in ``map``, shape (3,), in [m/s].
        """
        return replace(parameters, position=tuple(place.tolist()))

    @abstractmethod
    def position(self, time: float) -> NDArray[np.float64]:
        """True position in ``map``, shape (3,), in [m].

        Args:
            time: Since the target's start in [s].
        """

    @abstractmethod
    def velocity(self, time: float) -> NDArray[np.float64]:
        """True velocity in ``map``, shape (3,), in [m/s].

        At a corner, a start or a stop it is the velocity after it; a jump has none.

        Args:
            time: Since the target's start in [s].
        """


TARGET_MOTION = ExtensionPoint("target motion", TargetMotion)


def motion_of(parameters: TargetParameters) -> TargetMotion:
    """The motion that the parameters name.

    Args:
        parameters: Name and figures of the motion.

    Raises:
        ParameterError: There is no motion of that name, it fails, or it does not give three finite
            numbers.
    """
    name = parameters.motion
    try:
        motion = TARGET_MOTION.find(name)(parameters)
        begin = {"position": motion.position(0.0), "velocity": motion.velocity(0.0)}
        for what, value in begin.items():
            if np.shape(value) != (3,) or not np.isfinite(value).all():
                words = f"whose {what} is {value}, must be three finite numbers"
                raise ParameterError(f"parameter 'motion' is {name!r}, {words}")
        motion.starting(parameters, *begin.values())
    except ExtensionError as error:
        raise ParameterError(f"parameter 'motion': {error}") from error
    except ParameterError:
        raise
    except Exception as error:  # whatever a user's motion raises
        raise ParameterError(f"parameter 'motion' is {name!r}, which failed: {error}") from error
    return motion
