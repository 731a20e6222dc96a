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

"""When a flight has failed: conditions by name, each on the true trajectory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.limits import LIMIT
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.comparison.measures import violations

RAISED = "raised"  # what a flight that raised an error failed by
HARD = ("bank", "airspeed", "path_angle")  # limits of the airframe
CRITERIA = ("orbit_lost", "never_settled", "limit_passed")
_ARGUMENTS: dict[str, tuple[str, ...]] = {
    "orbit_lost": ("beyond", "settled_for"),
    "never_settled": (),
    "limit_passed": ("by", "limits"),
}


@dataclass(frozen=True)
class Criteria:
    """Conditions of failure.

    Attributes:
        names: Of those that count.
        beyond: Range error in [m] beyond which an orbit is lost, and inside which it is settled.
        settled_for: How long in [s] it must be inside to count as settled.
        by: Share of a bound [-] by which a limit may be passed.
        limits: Names of the limits that count.
    """

    names: tuple[str, ...] = CRITERIA
    beyond: float = 30.0
    settled_for: float = 20.0
    by: float = 0.05
    limits: tuple[str, ...] = HARD

    @classmethod
    def of(cls, written: Mapping[str, Any]) -> Criteria:
        """The conditions that YAML holds; all with their defaults where it names none.

        Args:
            written: Arguments by the name of the condition.

        Raises:
            ParameterError: An argument is unknown or not allowed.
        """
        if not written:
            return cls()
        values: dict[str, Any] = {}
        for name, arguments in written.items():
            if not isinstance(arguments, Mapping):
                raise ParameterError(f"failure: '{name}' is {arguments!r}, must be {{}} or hold "
                                     f"{', '.join(_ARGUMENTS[name]) or 'nothing'}")  # fmt: skip
            for key, value in arguments.items():
                if key not in _ARGUMENTS[name]:
                    raise ParameterError(f"failure: '{name}' has no '{key}'")
                values[key] = _limits(value) if key == "limits" else _positive(key, value)
        return cls(names=tuple(written), **values)

    def settled_at(self, time: NDArray[np.float64], error: NDArray[np.float64]) -> float | None:
        """When the flight has been inside long enough, in [s]; None if never.

        Args:
            time: Of the samples in [s], shape (n,).
            error: r - r_d in [m], shape (n,).
        """
        outside = np.flatnonzero(~(np.abs(error) <= self.beyond))
        begins = np.concatenate([time[:1], time[np.minimum(outside + 1, len(time) - 1)]])
        ends = np.concatenate([time[outside], time[-1:]])
        long = np.flatnonzero(ends - begins >= self.settled_for)
        return float(begins[long[0]]) + self.settled_for if len(long) else None

    def failures(
        self, log: FlightLog, error: NDArray[np.float64], parameters: TrackingParameters
    ) -> list[str]:
        """Conditions that a flight meets, with the limits' names.

        Args:
            log: Record of the flight.
            error: r - r_d in [m], shape (n,).
            parameters: The limits.
        """
        settled, found = self.settled_at(log.time, error), []
        if settled is None:
            found.append("never_settled")
        elif not np.all(np.abs(error[log.time >= settled]) <= self.beyond):
            found.append("orbit_lost")
        if "limit_passed" in self.names:
            passed = violations(log, parameters, self.by)
            counted = [name.replace("_", " ") for name in self.limits]
            found += [f"limit_passed:{each}" for each in counted if np.any(passed.get(each, False))]
        return [each for each in found if each.partition(":")[0] in self.names]


def _limits(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(name in LIMIT.names for name in value):
        raise ParameterError(
            f"failure: 'limits' is {value!r}, must be a list of some of {', '.join(LIMIT.names)}"
        )
    return tuple(value)


def _positive(key: str, value: Any) -> float:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not 0.0 < value < math.inf:
        raise ParameterError(f"failure: '{key}' is {value!r}, must be a positive number")
    return float(value)
