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

"""Linear limits on the ellipsoid: inputs in U, states in the model's domain, proved.

The largest value of c'x over x'Px <= varrho is sqrt(varrho c'P^-1 c), so a limit c'x < room holds
on all of X_f exactly when varrho c'P^-1 c < room^2. P^-1 is enclosed in ball arithmetic, hence
the levels below are proved, not estimated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import INPUT_NAMES
from uav_tracking_mpc.terminal.ball import PRECISION, flint
from uav_tracking_mpc.terminal.quadratic_bound import exact
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.terminal_dynamics import steady_balls


@dataclass(frozen=True)
class Limit:
    """One linear limit and the ellipsoids that respect it.

    Attributes:
        name: What it limits, in words.
        level: The limit holds for every x with x'Px <= level [-]; proved. 0 if not even at the
            origin.
    """

    name: str
    level: float


def input_limits(
    problem: StabilityProblem, gain: NDArray[np.float64], weight: NDArray[np.float64]
) -> list[Limit]:
    """K x + u_ss in U, (25), bound by bound.

    Args:
        problem: Its orbit, model and input box.
        gain: K, shape (3, 5).
        weight: P_rho, shape (5, 5).
    """
    arb = flint().arb
    with flint().ctx.workprec(PRECISION):
        _, u_ss = steady_balls(problem.model, problem.orbit)
        k = exact(gain)
        reach = k * exact(weight).inv() * k.transpose()
        limits = []
        for i, name in enumerate(INPUT_NAMES):
            for side, room in (
                ("lower", u_ss[i] - arb(float(problem.input_lower[i]))),
                ("upper", arb(float(problem.input_upper[i])) - u_ss[i]),
            ):
                limits.append(Limit(f"{side} bound of {name}", _level(room, reach[i, i])))
    return limits


def domain_limits(problem: StabilityProblem, weight: NDArray[np.float64]) -> list[Limit]:
    """The model's domain: r > |z|, hence d > 0, and a bearing error below half a turn.

    Args:
        problem: Its orbit.
        weight: P_rho, shape (5, 5).
    """
    module = flint()
    arb = module.arb
    with module.ctx.workprec(PRECISION):
        inverse = exact(weight).inv()
        orbit = problem.orbit
        limits = []
        for name, sign in (
            ("range above the height over the target, r > z", -1),
            ("range above the depth below the target, r > -z", 1),
        ):
            c = module.arb_mat([[1], [0], [sign], [0], [0]])
            room = arb(orbit.range) + arb(sign * orbit.altitude)
            limits.append(Limit(name, _level(room, (c.transpose() * inverse * c)[0, 0])))
        limits.append(
            Limit("bearing error below half a turn, |x_2| < pi", _level(arb.pi(), inverse[1, 1]))
        )
    return limits


def lowest(limits: list[Limit]) -> Limit:
    """The one of some ``limits`` that binds first."""
    return min(limits, key=lambda limit: limit.level)


def _level(room: object, reach: object) -> float:
    """A double below room^2 / reach, or 0 where room is not surely positive."""
    if not room > 0:  # type: ignore[operator]
        return 0.0
    ratio = room * room / reach  # type: ignore[operator]
    return float(ratio.abs_lower()) * (1.0 - 1e-12)
