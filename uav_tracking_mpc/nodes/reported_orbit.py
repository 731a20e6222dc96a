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

"""The orbit that is asked for, as values of the controller's diagnostics, and back from a bag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from uav_tracking_mpc.dynamics.orbit import Orbit

RANGE, ALTITUDE, AIRSPEED = "orbit range [m]", "orbit altitude [m]", "orbit airspeed [m/s]"
DIRECTION = "direction"


def orbit_values(orbit: Orbit) -> dict[str, object]:
    """Keys, with units, and values, to the last digit.

    Args:
        orbit: That is asked for.
    """
    numbers = {RANGE: orbit.range, ALTITUDE: orbit.altitude, AIRSPEED: orbit.speed}
    return {**{key: repr(value) for key, value in numbers.items()}, DIRECTION: orbit.direction}


def reported_orbit(values: Mapping[str, str]) -> Orbit | None:
    """The orbit of a report; None where it holds none.

    Args:
        values: Of the diagnostics of a controller.
    """
    try:
        range_, altitude, speed = (float(values[key]) for key in (RANGE, ALTITUDE, AIRSPEED))
        return Orbit(range_, altitude, speed, values[DIRECTION])
    except (KeyError, ValueError):
        return None


def orbit_changes(
    reports: Sequence[tuple[int, Orbit]], start: int
) -> tuple[tuple[float, Orbit], ...]:
    """When which orbit was asked for.

    Args:
        reports: Stamp in [ns] and orbit of each report, in order.
        start: Of the flight in [ns]; the first report after it tells the orbit since then.

    Returns:
        Time since the start in [s] and orbit of the first and of each that differs from the last.
    """
    changes: list[tuple[float, Orbit]] = []
    for stamp, orbit in reports:
        if stamp >= start and (not changes or changes[-1][1] != orbit):
            changes.append(((stamp - start) * 1e-9, orbit))
    return tuple(changes)
