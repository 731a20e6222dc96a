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

"""Terminal ingredients, Section 5.1: the local controller, P_rho, and X_f as far as U allows.

They belong to a :class:`StabilityProblem`: a model, an orbit, weights and an input set, as data.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, solve_discrete_are

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import error_dynamics, steady_inputs
from uav_tracking_mpc.symbolic.functions import BufferedFunction, linearise


@dataclass(frozen=True)
class TerminalIngredients:
    """What Section 5.1 attaches to a linearisation (A, B) and weights (Q, R).

    Attributes:
        gain: K of (24), shape (nu, nx): kappa_l(x) = K x, (23).
        riccati: P, solution of the Riccati equation for N = 1 and rho = 1, shape (nx, nx).
        weight: P_rho of (28), shape (nx, nx).
        closed_loop: A_K = A + B K, shape (nx, nx).
        scaling: rho [-].
    """

    gain: NDArray[np.float64]
    riccati: NDArray[np.float64]
    weight: NDArray[np.float64]
    closed_loop: NDArray[np.float64]
    scaling: float


def terminal_ingredients(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    state_weight: NDArray[np.float64],
    input_weight: NDArray[np.float64],
    scaling: float,
) -> TerminalIngredients:
    """Solve (24) and (28).

    P solves the discrete algebraic Riccati equation, which is
    A_K' P A_K - P + Q + K' R K = 0; (28) is that equation times rho, hence P_rho = rho P.

    Args:
        a: A of (12), shape (nx, nx).
        b: B of (12), shape (nx, nu).
        state_weight: Q, shape (nx, nx).
        input_weight: R, shape (nu, nu).
        scaling: rho >= 1 [-].

    Raises:
        ValueError: rho < 1, or (A, B) cannot be stabilised with these weights.
    """
    if not scaling >= 1.0:
        raise ValueError(f"scaling rho is {scaling}, must be at least 1")
    try:
        riccati = solve_discrete_are(a, b, state_weight, input_weight)
    except np.linalg.LinAlgError as error:
        raise ValueError(f"no stabilising terminal controller: {error}") from error
    riccati = 0.5 * (riccati + riccati.T)  # symmetric to the last bit: proofs take it as exact
    gain = -np.linalg.solve(b.T @ riccati @ b + input_weight, b.T @ riccati @ a)  # (24)
    return TerminalIngredients(
        gain=gain,
        riccati=riccati,
        weight=scaling * riccati,
        closed_loop=a + b @ gain,
        scaling=scaling,
    )


def input_limited_level(
    ingredients: TerminalIngredients,
    input_lower: NDArray[np.float64],
    input_upper: NDArray[np.float64],
) -> float:
    """Largest varrho for which K x stays in U on x' P_rho x <= varrho, (25).

    The maximum of K_i x over the ellipsoid is sqrt(varrho K_i P_rho^-1 K_i'). U is taken about the
    steady inputs, where its box need not be symmetric: the nearer bound counts.

    Args:
        ingredients: K and P_rho.
        input_lower: Lower bounds of u = ubar - u_ss, shape (nu,), negative.
        input_upper: Upper bounds of u, shape (nu,), positive.

    Returns:
        varrho_U, positive.

    Raises:
        ValueError: The steady inputs are not inside the box, so no set is admissible.
    """
    room = np.minimum(-np.asarray(input_lower), np.asarray(input_upper))
    if not np.all(room > 0.0):
        raise ValueError(
            f"steady inputs are not inside the input box: room to the bounds is {room}"
        )
    gain = ingredients.gain
    reach = np.einsum("ij,ji->i", gain, np.linalg.solve(ingredients.weight, gain.T))
    return float(np.min(room**2 / reach))


def relative_eigenvalues(
    matrix: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Eigenvalues of P^-1/2 M P^-1/2, ascending: those of the pencil (M, P).

    Args:
        matrix: M, shape (5, 5).
        weight: P, shape (5, 5).
    """
    return eigh(matrix, weight, eigvals_only=True)


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
        scheme: Name in :data:`uav_tracking_mpc.symbolic.functions.SCHEMES`.
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


class Excess:
    """|f(x, Kx) - C x|_P^2 - x' N x in floating point, with its gradient.

    Args:
        dynamics: f(x, u).
        gain: K, shape (nu, nx).
        weight: P, shape (nx, nx).
        right: N, shape (nx, nx).
        subtracted: C, shape (nx, nx), or None for 0.
    """

    def __init__(
        self,
        dynamics: ca.Function,
        gain: NDArray[np.float64],
        weight: NDArray[np.float64],
        right: NDArray[np.float64],
        subtracted: NDArray[np.float64] | None = None,
    ) -> None:
        self.weight = weight
        x = ca.SX.sym("x", len(weight))
        image = dynamics(x, ca.DM(gain) @ x)
        if subtracted is not None:
            image = image - ca.DM(subtracted) @ x
        left, right_side = ca.bilin(ca.DM(weight), image, image), ca.bilin(ca.DM(right), x, x)
        excess = left - right_side
        self._value = ca.Function("excess", [x], [excess])
        gradient = ca.densify(ca.gradient(excess, x))
        self._both = BufferedFunction(ca.Function("excess_gradient", [x], [excess, gradient]))

    def __call__(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values, shape (n,), at ``states`` of shape (n, 5); nan outside the model's domain."""
        return np.array(self._value(states.T)).ravel()

    def with_gradient(self, state: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Value and gradient, shape (5,), at one ``state`` of shape (5,)."""
        self._both.arguments[0][:] = state
        self._both.evaluate()
        (value,), gradient = self._both.results
        return float(value), gradient.copy()


def decrease_excess(problem: StabilityProblem, ingredients: TerminalIngredients) -> Excess:
    """V_f(f(x, Kx)) - V_f(x) + L(x, Kx): above 0 where V_f falls too little, (30).

    Args:
        problem: The configuration.
        ingredients: K and P_rho.
    """
    weight, gain = ingredients.weight, ingredients.gain
    return Excess(problem.dynamics(), gain, weight, weight - q_star(problem, gain))


def q_star(problem: StabilityProblem, gain: NDArray[np.float64]) -> NDArray[np.float64]:
    """Q* = Q + K'RK of Theorem 2, shape (5, 5).

    Args:
        problem: Its Q and R.
        gain: K, shape (3, 5).
    """
    return problem.state_weight + gain.T @ problem.input_weight @ gain


def directions(
    weight: NDArray[np.float64], count: int, generator: np.random.Generator
) -> NDArray[np.float64]:
    """States uniformly spread over x'Px = 1, shape (count, 5).

    Args:
        weight: P, shape (5, 5).
        count: How many.
        generator: Source of randomness.
    """
    whitened = generator.normal(size=(count, len(weight)))
    whitened /= np.linalg.norm(whitened, axis=1, keepdims=True)
    return whitened @ np.linalg.inv(np.linalg.cholesky(weight))
