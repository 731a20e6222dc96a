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

"""Parameters as an autopilot keeps them, and the numbers of the aircraft that both are told.

Names have at most 16 letters; values are integers and floats.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank
from uav_tracking_mpc.settings.configuration import Configuration

LARGEST = 2**31 - 1  # code, of the integers that PARAM_VALUE can hold


class OnboardParameters:
    """Values by name, in a fixed order; a value keeps the type of its default.

    Args:
        defaults: Value of each at the start [-].
    """

    def __init__(self, defaults: Mapping[str, float]) -> None:
        self._defaults = dict(defaults)
        self._values = dict(sorted(defaults.items()))

    @property
    def names(self) -> list[str]:
        """All names, in the order of their index."""
        return list(self._values)

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def integer(self, name: str) -> bool:
        """Whether a parameter is an integer.

        Args:
            name: One that exists.
        """
        return isinstance(self._defaults[name], int)

    def set(self, name: str, value: float) -> bool:
        """Change a value.

        Args:
            name: Of the parameter.
            value: New one [-]; rounded where the parameter is an integer.

        Returns:
            Whether there is such a parameter and the value is finite.
        """
        if name not in self._values or not math.isfinite(value):
            return False
        if self.integer(name):
            value = min(max(round(value), -LARGEST - 1), LARGEST)
        self._values[name] = value
        return True


LOITER_BANK = math.radians(30.0)  # rad, with which a loiter is flown in still air, at most


class VehicleNumbers(NamedTuple):
    """What an operator would have typed in.

    Attributes:
        cruise: Calibrated airspeed in [m/s].
        slowest: Least calibrated airspeed in [m/s].
        fastest: Greatest calibrated airspeed in [m/s].
        bank_max: In [deg].
        climb_max: Greatest climb rate at cruise in [m/s].
        sink_max: Greatest sink rate in [m/s].
        sink_idle: Sink rate at cruise with the engine idle in [m/s].
        roll_rate: Greatest roll rate in [deg/s].
        radius: Of a loiter that leaves room for wind, in [m], in tens.
    """

    cruise: float
    slowest: float
    fastest: float
    bank_max: float
    climb_max: float
    sink_max: float
    sink_idle: float
    roll_rate: float
    radius: int


def vehicle_numbers(configuration: Configuration, density_factor: float) -> VehicleNumbers:
    """Numbers of an aircraft.

    Args:
        configuration: What the controller is told of it, and its plant's limits.
        density_factor: True over equivalent airspeed at its start [-].
    """
    envelope, plant = configuration.controller, configuration.simulator
    cruise = envelope.airspeed
    sink = cruise * math.sin(-envelope.path_angle_min)
    turn = cruise / turn_rate_from_bank(-LOITER_BANK, cruise)
    return VehicleNumbers(
        cruise=round(cruise / density_factor, 2),
        slowest=max(envelope.airspeed_min, plant.speed_min) / density_factor,
        fastest=min(envelope.airspeed_max, plant.speed_max) / density_factor,
        bank_max=round(math.degrees(min(envelope.bank_max, plant.bank_max)), 2),
        climb_max=round(cruise * math.sin(envelope.path_angle_max), 2),
        sink_max=round(sink, 2),
        sink_idle=round(min(2.0, 0.5 * sink), 2),
        roll_rate=round(math.degrees(min(envelope.roll_rate_max, 4.0))),
        radius=10 * math.ceil(0.1 * turn),
    )
