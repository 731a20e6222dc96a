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

"""Theorems 2 and 3 of the paper as they are written, quantity by quantity.

Norms: |x|_P^2 = x'Px, so |x|_P is its root; |A_K|_P is the norm that it induces on matrices, and
the ellipsoid of (25) and (31) is x' P_rho x <= varrho.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from uav_tracking_mpc.terminal.ingredients import TerminalIngredients


def a_1(riccati: NDArray[np.float64]) -> float:
    """a_1 = lambda_min(P) of Theorem 2; ``riccati`` is P, shape (5, 5)."""
    return float(np.linalg.eigvalsh(riccati)[0])


def a_2(riccati: NDArray[np.float64]) -> float:
    """a_2 = lambda_max(P) of Theorem 2; ``riccati`` is P, shape (5, 5).

    V_f is |x|^2 in P_rho, so its upper bound needs lambda_max(P_rho) = rho a_2: another slip.
    """
    return float(np.linalg.eigvalsh(riccati)[-1])


def q_star(
    state_weight: NDArray[np.float64], input_weight: NDArray[np.float64], gain: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Q* = Q + K'RK of Theorem 2, shape (5, 5).

    Args:
        state_weight: Q, shape (5, 5).
        input_weight: R, shape (3, 3).
        gain: K, shape (3, 5).
    """
    return state_weight + gain.T @ input_weight @ gain


def _relative_eigenvalues(
    matrix: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Eigenvalues of P^-1/2 M P^-1/2, ascending: those of the pencil (M, P)."""
    return eigh(matrix, weight, eigvals_only=True)


def sigma(q_star: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """The sigma of Theorem 2 and (34): lambda_min(Z*), Z* = P_rho^-1/2 Q* P_rho^-1/2.

    Args:
        q_star: Q*, shape (5, 5).
        weight: P_rho, shape (5, 5).
    """
    return float(_relative_eigenvalues(q_star, weight)[0])


def eta(q_star: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """The eta of (44): lambda_max(Z*).

    Args:
        q_star: Q*, shape (5, 5).
        weight: P_rho, shape (5, 5).
    """
    return float(_relative_eigenvalues(q_star, weight)[-1])


def xi(state_weight: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """The xi of Theorem 3 and (52): lambda_min(Z), Z = P_rho^-1/2 Q P_rho^-1/2.

    Args:
        state_weight: Q, shape (5, 5).
        weight: P_rho, shape (5, 5).
    """
    return float(_relative_eigenvalues(state_weight, weight)[0])


def induced_norm(matrix: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """|A_K|_P = max |A_K x|_P / |x|_P, as in (33): root of lambda_max of (A_K'PA_K, P).

    Args:
        matrix: A_K, shape (5, 5).
        weight: P, shape (5, 5).
    """
    return float(np.sqrt(_relative_eigenvalues(matrix.T @ weight @ matrix, weight)[-1]))


def b(lipschitz: float, contraction: float) -> float:
    """The b of Theorem 2: 2 L |A_K|_P + L^2.

    Args:
        lipschitz: L [-].
        contraction: |A_K|_P [-].
    """
    return 2.0 * lipschitz * contraction + lipschitz**2


def a_3(scaling: float, sigma: float, b: float) -> float:
    """a_3 = rho sigma - b, the decrease of (37).

    Args:
        scaling: rho [-].
        sigma: (34) [-].
        b: Of Theorem 2 [-].
    """
    return scaling * sigma - b


def gamma(a_2: float, a_3: float) -> float:
    """The gamma of (38)-(39): 1 - a_3 / a_2.

    Args:
        a_2: lambda_max(P) [-].
        a_3: Decrease of (37) [-].
    """
    return 1.0 - a_3 / a_2


def tau(b: float, contraction: float) -> float:
    """The tau of (45): b + |A_K|_P^2.

    Args:
        b: Of Theorem 2 [-].
        contraction: |A_K|_P [-].
    """
    return b + contraction**2


def c_2(eta: float, tau: float, horizon: int) -> float:
    """c_2 = sum_{j=0}^{N-2} eta tau^j + tau^{N-1}, (47).

    Args:
        eta: (44) [-].
        tau: (45) [-].
        horizon: N.
    """
    return float(sum(eta * tau**j for j in range(horizon - 1)) + tau ** (horizon - 1))


def c_3(scaling: float, sigma: float, xi: float, b: float) -> float:
    """c_3 = xi + (rho - 1) sigma - b, (53).

    Args:
        scaling: rho [-].
        sigma: (34) [-].
        xi: (52) [-].
        b: Of Theorem 2 [-].
    """
    return xi + (scaling - 1.0) * sigma - b


def gamma_n(c_2: float, c_3: float) -> float:
    """gamma_n = 1 - c_3 / c_2, (55).

    Args:
        c_2: (47) [-].
        c_3: (53) [-].
    """
    return 1.0 - c_3 / c_2


@dataclass(frozen=True)
class Condition:
    """An inequality ``left >= right`` of the paper.

    Attributes:
        left: Its left side [-].
        right: Its right side [-].
    """

    left: float
    right: float

    @property
    def holds(self) -> bool:
        """Whether the inequality is true."""
        return bool(self.left >= self.right)

    def as_dict(self) -> dict[str, float | bool]:
        """For JSON."""
        return {"holds": self.holds, "left": self.left, "right": self.right}


@dataclass(frozen=True)
class TheoremQuantities:
    """Everything that Theorems 2 and 3 speak of, for one Lipschitz constant.

    Attributes:
        a_1: lambda_min(P) [-].
        a_2: lambda_max(P) [-].
        sigma: (34) [-].
        xi: (52) [-].
        eta: (44) [-].
        contraction: |A_K|_P [-].
        lipschitz: L of (27), (31) [-].
        b: 2 L |A_K|_P + L^2 [-].
        tau: (45) [-].
        c_2: (47) [-].
        c_3: (53) [-].
        gamma: (38) [-].
        gamma_n: (55) [-].
        scaling: rho [-].
        horizon: N.
    """

    a_1: float
    a_2: float
    sigma: float
    xi: float
    eta: float
    contraction: float
    lipschitz: float
    b: float
    tau: float
    c_2: float
    c_3: float
    gamma: float
    gamma_n: float
    scaling: float
    horizon: int

    @property
    def theorem2(self) -> Condition:
        """(29): rho sigma >= b."""
        return Condition(self.scaling * self.sigma, self.b)

    @property
    def theorem3(self) -> Condition:
        """(41): xi + (rho - 1) sigma >= b."""
        return Condition(self.xi + (self.scaling - 1.0) * self.sigma, self.b)


def largest_lipschitz(contraction: float, allowance: float) -> float:
    """The L at which b reaches an allowance: root of L^2 + 2 L |A_K|_P = allowance.

    Args:
        contraction: |A_K|_P [-].
        allowance: Greatest b that a condition admits [-].
    """
    return float(np.sqrt(contraction**2 + allowance) - contraction)


def theorem_quantities(
    ingredients: TerminalIngredients,
    state_weight: NDArray[np.float64],
    input_weight: NDArray[np.float64],
    lipschitz: float,
    horizon: int,
) -> TheoremQuantities:
    """Evaluate Theorems 2 and 3.

    Args:
        ingredients: K, P and P_rho.
        state_weight: Q, shape (5, 5).
        input_weight: R, shape (3, 3).
        lipschitz: L [-], (31), for the terminal level in question.
        horizon: N.
    """
    weight, scaling = ingredients.weight, ingredients.scaling
    star = q_star(state_weight, input_weight, ingredients.gain)
    smallest, largest = a_1(ingredients.riccati), a_2(ingredients.riccati)
    decay, share, top = sigma(star, weight), xi(state_weight, weight), eta(star, weight)
    contraction = induced_norm(ingredients.closed_loop, weight)
    allowance = b(lipschitz, contraction)
    growth = tau(allowance, contraction)
    upper, lower = c_2(top, growth, horizon), c_3(scaling, decay, share, allowance)
    return TheoremQuantities(
        a_1=smallest,
        a_2=largest,
        sigma=decay,
        xi=share,
        eta=top,
        contraction=contraction,
        lipschitz=lipschitz,
        b=allowance,
        tau=growth,
        c_2=upper,
        c_3=lower,
        gamma=gamma(largest, a_3(scaling, decay, allowance)),
        gamma_n=gamma_n(upper, lower),
        scaling=scaling,
        horizon=horizon,
    )
