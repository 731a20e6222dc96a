"""Steepest descent and climb."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from uav_tracking_mpc.limits import Bound, Limit, Motion
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class PathAngle(Limit):
    """path_angle_min <= chi <= path_angle_max."""

    name = "path_angle"

    path_angle_min: float = parameter(-1.2, "Steepest descent.", "rad", -1.5, -0.01)
    path_angle_max: float = parameter(1.2, "Steepest climb.", "rad", 0.01, 1.5)

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        return Bound(motion.path_angle, numbers[0], numbers[1], scale=0.1)
