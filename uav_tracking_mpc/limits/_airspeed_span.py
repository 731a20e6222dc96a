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

"""The span of airspeeds: what is limited itself, and what other limits are given over."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.limits import Limit
from uav_tracking_mpc.parameters.specification import ParameterError, parameter


@dataclass(frozen=True)
class AirspeedSpan(Limit):
    """A limit that knows the least and the greatest airspeed."""

    airspeed_min: float = parameter(0.0, "Least airspeed.", "m/s", 0.0, 300.0)
    airspeed_max: float = parameter(20.0, "Greatest airspeed.", "m/s", 0.1, 400.0)

    def __post_init__(self) -> None:
        """Refuse a span that is empty."""
        super().__post_init__()
        if not self.airspeed_max > self.airspeed_min:
            raise ParameterError(
                f"parameter 'airspeed_max' is {self.airspeed_max:g}, must be above "
                f"'airspeed_min' = {self.airspeed_min:g} m/s"
            )
