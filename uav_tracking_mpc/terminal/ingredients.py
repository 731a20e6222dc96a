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

"""Terminal ingredients, Section 5.1: the local controller, P_rho, and X_f as far as U allows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are


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
