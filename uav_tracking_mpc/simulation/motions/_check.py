"""Whether a target motion keeps what :class:`TargetMotion` asks for."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.parameters.conformance import require, require_array, require_name
from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion

FARTHEST, FASTEST = 1e7, 1e3  # m and m/s: what lies beyond is no ground target
STEP = 1e-4  # s, over which positions are compared with velocities
CHANGE = 1e-2  # m/s; a velocity that changes more in a step has a corner there


def check_motion(motion: type[TargetMotion]) -> None:
    """Fly a motion through 100 s and check every position and velocity.

    Args:
        motion: Class of the motion.

    Raises:
        ConformanceError: A position or velocity is not a finite (3,) array in [m] or [m/s], it
            depends on more than the time, or the velocity is not that of the position.
    """
    name = require_name(motion)
    parameters = TargetParameters(position=(10.0, -20.0, 3.0), speed=5.0, jump_time=1e6)
    target, again = motion(parameters), motion(parameters)
    require(target.parameters is parameters, f"{name}: __init__ must call super().__init__")
    times = np.linspace(0.0, 100.0, 401).tolist()
    for time in times:
        at = f"{name}: position({time:g})"
        position, velocity = target.position(time), target.velocity(time)
        require_array(position, (3,), FARTHEST, at)
        require_array(velocity, (3,), FASTEST, f"{name}: velocity({time:g})")
        position += 1.0
        require(
            not np.array_equal(position, target.position(time)),
            f"{at} hands out its own array: whoever changes it moves the target",
        )
        ahead, later = target.position(time + STEP), target.velocity(time + STEP)
        if np.linalg.norm(later - velocity) > CHANGE:
            continue
        flown = (ahead - target.position(time)) / STEP
        require(
            bool(np.linalg.norm(flown - 0.5 * (velocity + later)) <= 10.0 * CHANGE),
            f"{name}: velocity({time:g}) is {velocity.tolist()} m/s, the position moves with "
            f"{flown.tolist()} m/s",
        )
    for time in reversed(times):
        require(
            np.array_equal(target.position(time), again.position(time)),
            f"{name}: position({time:g}) depends on what was asked before, not on time alone",
        )
