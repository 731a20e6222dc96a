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

"""What the paper prints, number by number, and its problem recomputed in three ways."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.stability.theorems import (
    TheoremQuantities,
    largest_ratio,
    lipschitz_excess,
    theorem_quantities,
)
from uav_tracking_mpc.terminal.ingredients import (
    StabilityProblem,
    TerminalIngredients,
    paper_problem,
    terminal_ingredients,
)

PRINTED_A = np.array(
    [
        [1.0, 4.0, 0.0, 4.0, 0.0],
        [-0.0002, 1.0, 0.0001, -0.0302, 0.0075],
        [0.0, 0.0, 1.0, 4.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0],
    ]
)  # (58)
PRINTED_B = np.array(
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
)  # (58)
PRINTED_LEVEL_60 = 3.1733  # (60)
PRINTED_LEVEL_TABLE = 3.2649  # Table 1
PRINTED_LIPSCHITZ = 0.5265  # Table 1
PRINTED_LEFT_41 = 0.2782  # xi + (rho - 1) sigma, as Table 1 gives them
PRINTED_RIGHT_41 = 0.2762  # 2 L |A_K| + L^2, as Table 1 gives them


def symbolic_a(range_: float, altitude: float, speed: float, step: float) -> np.ndarray:
    """A of (12) evaluated, shape (5, 5).

    Args:
        range_: r_d in [m].
        altitude: z_d in [m].
        speed: v_d in [m/s].
        step: T_s in [s].
    """
    square = range_**2 - altitude**2
    a = np.eye(5)
    a[0, 1] = a[0, 3] = a[1, 0] = a[2, 3] = step * speed
    a[1, 2] = 2.0 * step * speed * range_ * altitude / square**2
    a[1, 3] = step * speed * range_ / square
    a[1, 4] = step * range_ / square
    return a


def distance_budget(
    problem: StabilityProblem, state: NDArray[np.float64], level: float
) -> tuple[float, float]:
    """Range to cover to reach X_f, and an upper bound for what can be flown in N steps.

    Each Euler step changes r by at most T_s v, and v is limited by the acceleration from the start
    and by the speeds that X_f holds at the end.

    Args:
        problem: Horizon, step, input bounds, weights.
        state: (r, theta, z, chi, v), shape (5,).
        level: varrho [-].

    Returns:
        (needed, possible), in [m]. needed > possible proves that (16e) is infeasible.
    """
    inverse = np.linalg.inv(problem.ingredients().weight)
    range_extent, _, _, _, speed_extent = np.sqrt(level * np.diag(inverse))
    r, _, _, _, v = state
    needed = abs(float(r) - problem.orbit.range) - float(range_extent)
    k = np.arange(problem.horizon)
    _, _, up = problem.step * problem.input_upper
    _, _, down = -problem.step * problem.input_lower
    last = problem.orbit.speed + float(speed_extent)
    speeds = np.minimum(v + k * up, last + (problem.horizon - k) * down)
    return needed, float(problem.step * np.maximum(speeds, 0.0).sum())


@dataclass(frozen=True)
class PaperCase:
    """One way to recompute.

    Attributes:
        problem: The plant.
        ingredients: Made with ``linearisation``.
        linearisation: A, shape (5, 5).
    """

    problem: StabilityProblem
    ingredients: TerminalIngredients
    linearisation: NDArray[np.float64]

    def quantities(self, lipschitz: float) -> TheoremQuantities:
        """Theorems 2 and 3.

        Args:
            lipschitz: L [-].
        """
        return theorem_quantities(self.problem, self.ingredients, lipschitz)

    def lipschitz(self, level: float) -> float:
        """L of (31), attained.

        Args:
            level: varrho [-].
        """
        return largest_ratio(lipschitz_excess(self.problem, self.ingredients, 0.0), level).level


@functools.cache
def paper_cases() -> tuple[PaperCase, ...]:
    """In the order of the columns: with the printed A, with (11), with the exact kinematics."""
    plant = paper_problem("paper")
    a, b = PRINTED_A, PRINTED_B
    weights = (plant.state_weight, plant.input_weight, plant.scaling)
    cases = [PaperCase(plant, terminal_ingredients(a, b, *weights), a)]
    for model in ("paper", "exact"):
        problem = paper_problem(model)
        cases.append(PaperCase(problem, problem.ingredients(), problem.linearisation()[0]))
    return tuple(cases)
