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

"""How the aircraft answers commands, as values for /diagnostics."""

from __future__ import annotations

from uav_tracking_mpc.control.adaptation import ResponseAdaptation
from uav_tracking_mpc.estimation.channel_response import CHANNELS


def response_values(response: ResponseAdaptation) -> dict[str, object]:
    """Keys, with units, and values: estimates with standard deviations, and what is flown by.

    Args:
        response: Of the controller.
    """
    values: dict[str, object] = {}
    lags, dead_times, gains = response.flown
    for axis, (name, channel) in enumerate(zip(CHANNELS, response.channels, strict=True)):
        if response.enabled:
            values |= {
                f"{name} lag estimated [s]": channel.lag,
                f"{name} lag deviation [s]": channel.lag_deviation,
                f"{name} dead time estimated [s]": channel.dead_time,
                f"{name} dead time deviation [s]": channel.dead_time_deviation,
                f"{name} lag and dead time estimated [s]": channel.delay,
                f"{name} lag and dead time deviation [s]": channel.delay_deviation,
                f"{name} gain estimated": channel.gain,
                f"{name} gain deviation": channel.gain_deviation,
                f"{name} response trusted": channel.trusted,
                f"{name} gain trusted": channel.gain_trusted,
            }
        values |= {
            f"{name} lag flown by [s]": float(lags[axis]),
            f"{name} dead time flown by [s]": float(dead_times[axis]),
            f"{name} gain flown by": float(gains[axis]),
        }
    for axis in range(2):
        values[f"limit cycle of the {CHANNELS[axis]}"] = response.oscillation.words(axis)
    return values
