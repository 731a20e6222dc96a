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

"""The fallback mode in the controller's diagnostics: as values, and back from a bag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.simulation.flight_log import FlownMode

MODE, REASON = "mode", "mode reason"


def reported_mode(values: Mapping[str, str]) -> tuple[FallbackMode, str] | None:
    """Mode of a report and why it is none better; None where it tells none.

    Args:
        values: Of the diagnostics of a controller.
    """
    try:
        return FallbackMode(values[MODE]), values.get(REASON, "")
    except (KeyError, ValueError):
        return None


def mode_changes(
    reports: Sequence[tuple[int, FallbackMode, str]], start: int, end: int
) -> tuple[FlownMode, ...]:
    """When which mode was flown.

    Args:
        reports: Stamp in [ns], mode and reason of each report, in order.
        start: Of the flight in [ns]; the first report after it tells the mode since then.
        end: Of the flight in [ns]; later reports do not count.

    Returns:
        The first mode and each that differs from the one before, times since the start.
    """
    changes: list[FlownMode] = []
    for stamp, mode, reason in reports:
        if start <= stamp <= end and (not changes or changes[-1].mode is not mode):
            changes.append(FlownMode((stamp - start) * 1e-9 if changes else 0.0, mode, reason))
    return tuple(changes)
