r"""The vehicle (3) behind inner loops that lag, in an air mass that drifts.

Each of the rates (psi', chi', v') follows its command u with a time constant tau,
:math:`\tau \dot\omega = u - \omega`; under held commands that has a closed solution, and so have
heading, path angle and airspeed. Position relative to the target integrates air velocity plus
drift; the air velocity by Simpson's rule, exact to fourth order in the step.

Written for numbers and for CasADi symbols alike: the equations stand once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import casadi as ca

LAG_STATES = ("turn rate", "path-angle rate", "acceleration")


def advance(
    state: Sequence[Any],
    inputs: Sequence[Any],
    duration: float,
    lag: Sequence[float],
    drift: Sequence[Any],
    drift_rate: Sequence[Any],
    symbolic: bool = False,
) -> list[Any]:
    """State after ``duration`` under held commands.

    Args:
        state: (x, y, z, psi, chi, v, psi', chi', v'), position relative to the target; without
            the last three if ``lag`` is empty, the commands then act at once.
        inputs: (u_psi, u_chi, u_v), held.
        duration: In [s].
        lag: Time constants (3,) in [s], positive; or empty.
        drift: c at the beginning, (3,), in [m/s].
        drift_rate: c', (3,), in [m/s^2].
        symbolic: Whether the values are CasADi expressions.

    Returns:
        As ``state``; angles are not wrapped.
    """
    cos, sin = (ca.cos, ca.sin) if symbolic else (math.cos, math.sin)

    def attitude(time: float) -> list[Any]:
        """Heading, path angle and airspeed."""
        values = []
        for axis in range(3):
            value = state[3 + axis] + inputs[axis] * time
            if lag:
                share = lag[axis] * -math.expm1(-time / lag[axis])
                value = value + (state[6 + axis] - inputs[axis]) * share
            values.append(value)
        return values

    def velocity(time: float) -> list[Any]:
        psi, chi, v = attitude(time) if time else state[3:6]
        level = v * cos(chi)
        return [level * cos(psi), level * sin(psi), v * sin(chi)]

    begin, middle, end = velocity(0.0), velocity(0.5 * duration), velocity(duration)
    following = [
        state[axis]
        + duration / 6.0 * (begin[axis] + 4.0 * middle[axis] + end[axis])
        + duration * drift[axis]
        + 0.5 * duration**2 * drift_rate[axis]
        for axis in range(3)
    ]
    following += attitude(duration)
    if lag:
        following += [
            inputs[axis] + (state[6 + axis] - inputs[axis]) * math.exp(-duration / lag[axis])
            for axis in range(3)
        ]
    return following
