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

"""What the controller is told of delays and noise, and what it finds out by itself."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.parameters.specification import Parameters, parameter


@dataclass(frozen=True)
class EstimationParameters(Parameters):
    """Part of :class:`~uav_tracking_mpc.settings.tracking.TrackingParameters`."""

    dead_time: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Time until a command of turn rate, path-angle rate, acceleration begins to act.",
        "s",
        0.0,
        2.0,
        size=3,
    )
    response_estimation: bool = parameter(
        False,
        "Estimate lag, dead time and gain in flight and fly by them; needs the artificial orbit.",
    )
    excitation: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Amplitudes of a test signal on turn rate, path-angle rate, acceleration once the flight "
        "has settled, in their units; 0 for none. For `identify`.",
        lower=0.0,
        upper=5.0,
        size=3,
    )
    state_timeout: float = parameter(
        0.5, "Age at which the vehicle's state counts as lost.", "s", 0.01, 60.0
    )
    target_timeout: float = parameter(
        5.0, "Age at which the target's position counts as lost.", "s", 0.01, 600.0
    )
    target_noise: float = parameter(
        0.1,
        "Standard deviation of the target's measured position, until it is found in flight.",
        "m",
        1e-3,
        1e3,
    )
    target_agility: float = parameter(
        0.5, "How hard the target accelerates, until it is found in flight.", "m/s^2", 1e-3, 100.0
    )
    air_estimation: bool = parameter(
        False,
        "Estimate mean wind, gusts, noise and biases of the sensors; else measurements count as "
        "they are.",
        fixed=True,
    )
    delay_margin_min: float = parameter(
        0.3,
        "Delay that the closed loop shall bear in each channel beyond what it is told; a warning "
        "is given where it is less.",
        "s",
        0.0,
        10.0,
    )
    gain_margin_min: float = parameter(
        6.0, "Likewise of the gain of each channel, up and down.", "dB", 0.0, 60.0
    )
