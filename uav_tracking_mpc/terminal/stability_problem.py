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

"""What the analysis is about: a model, an orbit, weights and an input set, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.discretisation import error_dynamics, linearise
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.terminal.ingredients import TerminalIngredients, terminal_ingredients


@dataclass(frozen=True)
class StabilityProblem:
    """One configuration of the controller, as far as its stability depends on it.

    Attributes:
        orbit: Reference (r_d, z_d, v_d) and direction.
        state_weight: Q, shape (5, 5).
        input_weight: R, shape (3, 3).
        scaling: rho of (28) [-].
        input_lower: Lower bounds of ubar = (u_psi, u_chi, u_v), shape (3,).
        input_upper: Upper bounds of ubar, shape (3,), in [rad/s, rad/s, m/s^2].
        step: T_s in [s].
        horizon: N.
        model: Name of a relative model.
        scheme: Name in :data:`uav_tracking_mpc.dynamics.discretisation.SCHEMES`.
        name: What a report calls it.
    """

    orbit: Orbit
    state_weight: NDArray[np.float64]
    input_weight: NDArray[np.float64]
    scaling: float
    input_lower: NDArray[np.float64]
    input_upper: NDArray[np.float64]
    step: float = paper_numbers.STEP
    horizon: int = paper_numbers.HORIZON
    model: str = "exact"
    scheme: str = "euler"
    name: str = field(default="unnamed", compare=False)

    def dynamics(self) -> ca.Function:
        """f(x, u) of (10) in error form."""
        return error_dynamics(self.model, self.orbit, self.step, self.scheme)

    def linearisation(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A, shape (5, 5), and B, shape (5, 3), of (12), by automatic differentiation."""
        return linearise(self.dynamics())

    def ingredients(self) -> TerminalIngredients:
        """K of (24) and P_rho of (28)."""
        return self._ingredients

    @cached_property
    def _ingredients(self) -> TerminalIngredients:
        a, b = self.linearisation()
        return terminal_ingredients(a, b, self.state_weight, self.input_weight, self.scaling)

    def deviation_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The box U about the steady inputs: bounds of u = ubar - u_ss, each of shape (3,)."""
        u_ss = steady_inputs(self.model, self.orbit)
        return self.input_lower - u_ss, self.input_upper - u_ss


def paper_problem(model: str = "exact", **changes: object) -> StabilityProblem:
    """Table 1 and (59) of the paper; U, which it never prints, as its terminal level implies.

    Args:
        model: ``exact`` by default; ``paper`` for (11).
        changes: Fields of :class:`StabilityProblem` to give other values.
    """
    bound = np.array(paper_numbers.INPUT_BOUNDS)
    values: dict[str, object] = {
        "orbit": paper_numbers.ORBIT,
        "state_weight": np.diag(paper_numbers.STATE_WEIGHTS),
        "input_weight": np.diag(paper_numbers.INPUT_WEIGHTS),
        "scaling": paper_numbers.SCALING,
        "input_lower": -bound,
        "input_upper": bound,
        "model": model,
        "name": "paper",
    }
    values.update(changes)
    return StabilityProblem(**values)  # type: ignore[arg-type]


PAPER_INITIAL_STATE = np.array(paper_numbers.INITIAL_STATE)
"""x_o of Section 6: (r, theta, z, chi, v), the actual state, not the error."""
