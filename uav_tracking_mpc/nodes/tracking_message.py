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

"""What the controller tracks by, ``uav/tracking_errors``: figures by name, with one stamp.

Plotting tools show each name of a JointState by itself. Who listens finds a figure by its name:
more may follow.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.conversions import set_stamp
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.message_checks import MessageError

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

TOPIC = "uav/tracking_errors"
ERRORS = ["range_error", "bearing_error", "altitude_error", "pitch_error", "speed_error"]
TARGET = ["target_east", "target_north", "target_up"]
WIND = ["wind_east", "wind_north", "wind_up"]
NAMES = [*ERRORS, "bank", *TARGET, "target_std", *WIND, "mode"]
MODES = tuple(FallbackMode)  # by the number of "mode"


def tracking_message() -> JointState:
    """A message to be filled by :func:`set_tracking` again and again."""
    from sensor_msgs.msg import JointState

    return JointState(name=NAMES, position=[0.0] * len(NAMES))


def set_tracking(
    message: JointState,
    stamp: int,
    situation: Situation,
    orbit: Orbit,
    target_std: float,
    wind: NDArray[np.float64],
    mode: FallbackMode,
    frames: FrameNames = FRAMES,
) -> None:
    """Fill a message.

    Args:
        message: Made by :func:`tracking_message`; changed in place.
        stamp: Of the state in [ns].
        situation: At the stamp.
        orbit: What is wanted.
        target_std: Standard deviation of the target's position on each axis in [m].
        wind: As estimated, in ``map``, shape (3,), in [m/s].
        mode: What is flown.
        frames: Of the message.
    """
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = frames.map
    turn_rate, _, _ = situation.rates.tolist()
    figures = [
        *situation.tracking_error(orbit).tolist(),
        bank_from_turn_rate(turn_rate, situation.airspeed),
        *situation.target.tolist(),
        target_std,
        *wind.tolist(),
        float(MODES.index(mode)),
    ]
    for index, figure in enumerate(figures):
        message.position[index] = figure


def tracking_figures(message: JointState) -> dict[str, float]:
    """The figures of a message by name, in SI units; those that are not finite are left out.

    Args:
        message: As in ``uav/tracking_errors``.

    Raises:
        MessageError: Another number of names than of values.
    """
    if len(message.name) != len(message.position):
        raise MessageError(
            f"{TOPIC}: name has {len(message.name)} entries, must have as many as "
            f"position, {len(message.position)}"
        )
    pairs = zip(message.name, message.position, strict=True)
    return {name: figure for name, figure in pairs if math.isfinite(figure)}


def told_mode(number: float) -> FallbackMode | None:
    """The mode of a number; None where it is none.

    Args:
        number: As of ``mode`` [-].
    """
    return MODES[int(number)] if number in range(len(MODES)) else None
