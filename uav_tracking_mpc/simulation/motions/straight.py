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

"""Targets that stand or run straight on: always, with stops, turns or a jump, or weaving."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion


class Stationary(TargetMotion):
    """Stands at ``position``."""

    name = "stationary"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        return self._start.copy()

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        return np.zeros(3)


class Line(TargetMotion):
    """Runs from ``position`` with ``speed`` towards ``heading``.

    Args:
        parameters: Start, speed and heading.
    """

    name = "line"

    def __init__(self, parameters: TargetParameters) -> None:
        super().__init__(parameters)
        heading = parameters.heading
        self._direction = np.array([np.cos(heading), np.sin(heading), 0.0])

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        return self._start + self.parameters.speed * time * self._direction

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        return self.parameters.speed * self._direction


class Jump(Line):
    """Runs like :class:`Line` and is moved by ``jump_offset`` at ``jump_time``."""

    name = "jump"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        offset = self.parameters.jump_offset if time >= self.parameters.jump_time else 0.0
        return super().position(time) + offset


class StopAndGo(Line):
    """Runs like :class:`Line` for ``drive_time``, stands for ``stand_time``, and so on."""

    name = "stop_and_go"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        rounds, rest = divmod(time, self._round)
        driven = rounds * self.parameters.drive_time + min(rest, self.parameters.drive_time)
        return super().position(driven)

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        drives = time % self._round < self.parameters.drive_time
        return super().velocity(time) if drives else np.zeros(3)

    @property
    def _round(self) -> float:
        return self.parameters.drive_time + self.parameters.stand_time


class Zigzag(Line):
    """Runs like :class:`Line` for ``drive_time``, as long 90 deg to the left of it, and so on."""

    name = "zigzag"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        drive_time = self.parameters.drive_time
        rounds, rest = divmod(time, 2.0 * drive_time)
        east, north, up = super().position(rounds * drive_time + min(rest, drive_time))
        sideways = rounds * drive_time + max(0.0, rest - drive_time)
        d_east, d_north, _ = self.parameters.speed * sideways * self._direction
        return np.array([east - d_north, north + d_east, up])

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        east, north, up = super().velocity(time)
        if time % (2.0 * self.parameters.drive_time) < self.parameters.drive_time:
            return np.array([east, north, up])
        return np.array([-north, east, up])


class Weaving(Line):
    """Runs like :class:`Line` and swings across its way."""

    name = "weaving"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        frequency = 2.0 * np.pi / self.parameters.weave_period
        aside = self.parameters.weave_speed / frequency * (1.0 - np.cos(frequency * time))
        return super().position(time) + aside * self._across

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        phase = 2.0 * np.pi * time / self.parameters.weave_period
        return super().velocity(time) + self.parameters.weave_speed * np.sin(phase) * self._across

    @property
    def _across(self) -> NDArray[np.float64]:
        east, north, _ = self._direction
        return np.array([-north, east, 0.0])
