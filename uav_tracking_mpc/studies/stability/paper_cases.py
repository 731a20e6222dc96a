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

"""The paper's problem recomputed in three ways."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.stability import printed
from uav_tracking_mpc.terminal.ingredients import TerminalIngredients, terminal_ingredients
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem, paper_problem
from uav_tracking_mpc.terminal.theorems import TheoremQuantities, q_star, theorem_quantities
from uav_tracking_mpc.terminal.violation import Excess, largest_ratio


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

    def excess(self, right: NDArray[np.float64], lipschitz: bool) -> Excess:
        """What the search for violations maximises.

        Args:
            right: Matrix of the quadratic form on the right of the inequality, shape (5, 5).
            lipschitz: Of (31), the nonlinear part alone; else of the decrease of V_f.
        """
        parts = self.ingredients
        return Excess(
            self.problem.dynamics(),
            parts.gain,
            parts.weight,
            right,
            parts.closed_loop if lipschitz else None,
        )

    @property
    def q_star(self) -> NDArray[np.float64]:
        """Q + K'RK, shape (5, 5)."""
        problem = self.problem
        return q_star(problem.state_weight, problem.input_weight, self.ingredients.gain)

    def quantities(self, lipschitz: float) -> TheoremQuantities:
        """Theorems 2 and 3.

        Args:
            lipschitz: L [-].
        """
        problem = self.problem
        weights = (problem.state_weight, problem.input_weight)
        return theorem_quantities(self.ingredients, *weights, lipschitz, problem.horizon)

    def lipschitz(self, level: float) -> float:
        """L of (31), attained.

        Args:
            level: varrho [-].
        """
        weight = self.ingredients.weight
        return largest_ratio(self.excess(0.0 * weight, True), level).level


@functools.cache
def paper_cases() -> tuple[PaperCase, ...]:
    """In the order of the columns: with the printed A, with (11), with the exact kinematics."""
    plant = paper_problem("paper")
    a, b = printed.PRINTED_A, printed.PRINTED_B
    weights = (plant.state_weight, plant.input_weight, plant.scaling)
    cases = [PaperCase(plant, terminal_ingredients(a, b, *weights), a)]
    for model in ("paper", "exact"):
        problem = paper_problem(model)
        cases.append(PaperCase(problem, problem.ingredients(), problem.linearisation()[0]))
    return tuple(cases)
