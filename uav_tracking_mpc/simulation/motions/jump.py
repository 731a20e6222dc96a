"""A target that is somewhere else at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions.line import Line


class Jump(Line):
    """Runs like :class:`Line` and is moved by ``jump_offset`` at ``jump_time``."""

    name = "jump"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        offset = self.parameters.jump_offset if time >= self.parameters.jump_time else 0.0
        return super().position(time) + offset
