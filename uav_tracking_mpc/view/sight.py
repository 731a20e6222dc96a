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

"""What there is to see of one aircraft at one time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit


@dataclass(frozen=True)
class TargetSight:
    """The target at one time.

    Attributes:
        position: Where the controller takes it to be, else where it was measured, in ``map``, shape
            (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s]; None where it is not known.
        std: Standard deviation of ``position`` on each axis in [m], nan where it is not known.
        measured: Newest measurement in ``map``, shape (3,), in [m]; None where there is none.
        truth: Where it truly is in ``map``, shape (3,), in [m]; None where nobody says so.
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None = None
    std: float = math.nan
    measured: NDArray[np.float64] | None = None
    truth: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class NodeStatus:
    """What a node says of itself.

    Attributes:
        node: Its name.
        level: 0 ok, 1 warning, 2 error, 3 silent, as in diagnostic_msgs.
        words: What people read.
        values: Further figures, as text with units.
    """

    node: str
    level: int
    words: str
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Sight:
    """One aircraft at one time.

    Attributes:
        time: Of the flight's clock in [s].
        position: In ``map``, shape (3,), in [m].
        heading: psi of the velocity through the air in [rad].
        path_angle: chi of it in [rad], positive up.
        bank: In [rad], positive to the right.
        airspeed: In [m/s], nan where it is not known.
        ground_velocity: In ``map``, shape (3,), in [m/s].
        wind: In ``map``, shape (3,), in [m/s]; None where it is not known.
        target: None before it is known.
        wanted: The orbit that is asked for; None before the target is known.
        flown: The orbit that the plan ends on; None where there is none.
        plan: Planned positions from now on, shape (n, 3), in [m]; None where there is none.
        mode: What is flown; None before the first command.
        reason: Why it is not optimal, in words; empty if it is.
        errors: Of range [m], bearing [rad], altitude [m], path angle [rad], speed [m/s], by the
            names ``range_error`` and so on; empty before the target is known.
        cost: Optimal cost [-], nan where there is none.
        solve_time: Of the newest solve in [s], nan where there is none.
        latency: From a state's stamp to its command in [s], nan where it is not measured.
        statuses: What the nodes say of themselves.
    """

    time: float
    position: NDArray[np.float64]
    heading: float
    path_angle: float
    bank: float
    airspeed: float
    ground_velocity: NDArray[np.float64]
    wind: NDArray[np.float64] | None = None
    target: TargetSight | None = None
    wanted: FlownOrbit | None = None
    flown: FlownOrbit | None = None
    plan: NDArray[np.float64] | None = None
    mode: FallbackMode | None = None
    reason: str = ""
    errors: Mapping[str, float] = field(default_factory=dict)
    cost: float = math.nan
    solve_time: float = math.nan
    latency: float = math.nan
    statuses: tuple[NodeStatus, ...] = ()
