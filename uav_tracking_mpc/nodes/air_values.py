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

"""What is known of the air and of the sensors' biases, as values for /diagnostics."""

from __future__ import annotations

import math

from uav_tracking_mpc.estimation.wind_filter import WindFilter

AXES = ("east", "north", "up")


def air_values(air: WindFilter) -> dict[str, object]:
    """Keys, with units, and values.

    Args:
        air: Filter of wind and biases.
    """
    vectors = {
        "mean wind": air.mean_wind,
        "gust": air.gust,
        "bias of ground velocity": air.ground_velocity_bias,
    }
    return {
        **{
            f"{name} {axis} [m/s]": value
            for name, vector in vectors.items()
            for axis, value in zip(AXES, vector.tolist(), strict=True)
        },
        "airspeed reads too much by [%]": 100.0 * air.airspeed_share,
        "bias of heading [deg]": math.degrees(air.heading_bias),
    }
