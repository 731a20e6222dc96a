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

r"""An autopilot that holds altitude and airspeed by its energy: what its rates are then.

The height error e_h asks for a climb rate w, the airspeed error e_v for an acceleration, each over
a time constant and as far as the engine and the glide allow; the climb rate follows over another:

.. math::

    w^* = S(e_h / T_h,\, -w_-,\, w_+), \qquad
    u_\chi = \frac{w^* - w}{T_w\, v \cos\chi}, \qquad
    u_v = S\bigl(e_v / T_v,\, -\tfrac{g w_0}{2 v},\, \tfrac{g w_+}{2 v}\bigr),

with :math:`S(a, -l, m) = a / \sqrt[4]{1 + (a / b)^4}`, b = m above and l below 0: smooth, between
-l and m, and a where that is small. The total energy control of ArduPlane is told the same numbers:
TECS_TIME_CONST, TECS_CLMB_MAX (``w_+``), TECS_SINK_MAX (``w_-``) and TECS_SINK_MIN (``w_0``); half
of the specific energy rate between the latter and the first may go into speed
(ArduPilot, AP_TECS.cpp, ``_update_speed_demand``).
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.parameters.specification import Parameters, parameter

SPEED_SHARE = 0.5  # -, of the specific energy rate, that may go into speed
SLOWEST = 1.0  # m/s, at which v cos(chi) is held, so that no iterate divides by nothing


class HoldConstants(NamedTuple):
    """How quickly an autopilot brings altitude and airspeed back; numbers or symbols.

    Attributes:
        height_time: T_h in [s].
        climb_time: T_w in [s].
        airspeed_time: T_v in [s].
        climb_max: ``w_+`` in [m/s], positive.
        sink_max: ``w_-`` in [m/s], positive.
        sink_idle: ``w_0``, sink rate at constant airspeed with the engine idle, in [m/s], positive.
    """

    height_time: Any
    climb_time: Any
    airspeed_time: Any
    climb_max: Any
    sink_max: Any
    sink_idle: Any


@dataclass(frozen=True)
class HoldParameters(Parameters):
    """The constants as parameters; the defaults are those of ArduPlane."""

    hold_time: tuple[float, ...] = parameter(
        (5.0, 1.0, 5.0),
        "Where the autopilot holds altitude and airspeed: time constants with which it takes "
        "errors of height, climb rate and airspeed out.",
        "s",
        0.1,
        60.0,
        size=3,
    )
    hold_climb_max: float = parameter(
        5.0, "Greatest climb rate of an autopilot that holds the altitude.", "m/s", 0.1, 50.0
    )
    hold_sink_max: float = parameter(
        5.0, "Greatest sink rate of an autopilot that holds the altitude.", "m/s", 0.1, 50.0
    )
    hold_sink_idle: float = parameter(
        2.0, "Sink rate at constant airspeed with the engine idle.", "m/s", 0.05, 50.0
    )

    @property
    def hold_constants(self) -> HoldConstants:
        """What :func:`hold` is told."""
        height, climb, airspeed = self.hold_time
        limits = self.hold_climb_max, self.hold_sink_max, self.hold_sink_idle
        return HoldConstants(height, climb, airspeed, *limits)


def hold(
    height_error: Any,
    climb_rate: Any,
    path_angle: Any,
    airspeed: Any,
    airspeed_error: Any,
    constants: HoldConstants,
    xp: ModuleType,
) -> tuple[Any, Any]:
    """Path-angle rate and acceleration that the autopilot wants.

    Args:
        height_error: e_h, the altitude to hold less that of the aircraft, in [m]: a number, an
            array of shape (n,) or a symbol, and so are all others.
        climb_rate: w, of the aircraft less that of the altitude to hold, in [m/s].
        path_angle: chi of the velocity through the air in [rad].
        airspeed: v in [m/s].
        airspeed_error: e_v, the airspeed to hold less v, in [m/s].
        constants: Of the autopilot.
        xp: ``casadi``, ``numpy`` or ``math``.

    Returns:
        u_chi in [rad/s] and u_v in [m/s^2].
    """
    height_time, climb_time, airspeed_time, climb_max, sink_max, sink_idle = constants
    wanted = saturated(height_error / height_time, sink_max, climb_max, xp)
    level = _at_least(airspeed * xp.cos(path_angle), SLOWEST)
    per_speed = SPEED_SHARE * GRAVITY / _at_least(airspeed, SLOWEST)
    return (
        (wanted - climb_rate) / (climb_time * level),
        saturated(airspeed_error / airspeed_time, per_speed * sink_idle, per_speed * climb_max, xp),
    )


def saturated(value: Any, lowest: Any, highest: Any, xp: ModuleType) -> Any:
    """S of the module's docstring, between -lowest and highest.

    Args:
        value: a, in any unit [SI], scalar or any shape, or a symbol; so are the others.
        lowest: l in [SI], positive.
        highest: m in [SI], positive.
        xp: ``casadi``, ``numpy`` or ``math``.
    """
    above, below = 0.5 * (abs(value) + value), 0.5 * (abs(value) - value)
    return value / xp.sqrt(xp.sqrt(1.0 + (above / highest) ** 4 + (below / lowest) ** 4))


def _at_least(value: Any, least: float) -> Any:
    return 0.5 * (value + least + abs(value - least))
