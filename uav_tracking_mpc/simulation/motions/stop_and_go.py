"""A target that runs straight on, with stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions.line import Line


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
