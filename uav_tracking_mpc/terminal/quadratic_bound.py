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

r"""The one kind of inequality that the analysis has to prove, as data.

.. math:: |f(x, Kx) - C x|_P^2 \le x' N x \quad \text{for every } x \text{ with } x' P x \le \alpha

- C = 0, N = P - Q - K'RK - s P: the direct condition V_f(f) - V_f(x) + L(x, Kx) <= -s V_f(x), all
  that the proofs of Theorems 2 and 3 use of (30);
- C = A_K, N = L^2 P: the Lipschitz bound |g(x)|_P <= L |x|_P of (27) and (31).

P, K, Q, R and C are floating-point data and are taken as the exact rational numbers that they are;
N is computed from them in ball arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.ball import PRECISION, flint
from uav_tracking_mpc.terminal.terminal_dynamics import ClosedLoopBalls


@dataclass(frozen=True)
class QuadraticBound:
    """The inequality of the module's docstring.

    Attributes:
        closed_loop: f(x, K x) in ball arithmetic.
        weight: P, symmetric positive definite, shape (5, 5).
        right: N as an ``arb_mat``.
        level: varrho [-].
        subtracted: C, shape (5, 5), or None for 0.
    """

    closed_loop: ClosedLoopBalls
    weight: NDArray[np.float64]
    right: Any
    level: float
    subtracted: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Symmetric matrices: the tests take gradients of x'Px and x'Nx as 2Px and 2Nx."""
        if not np.array_equal(self.weight, np.transpose(self.weight)):
            raise ValueError("P must be symmetric to the last bit")
        if not np.isfinite(self.level) or self.level <= 0.0:
            raise ValueError(f"level is {self.level}, must be positive and finite")
        # x'Nx is the same for N and its symmetric part.
        symmetric = (self.right + self.right.transpose()) / 2
        object.__setattr__(self, "right", symmetric)


def exact(matrix: NDArray[np.float64]) -> Any:
    """``arb_mat`` of a floating-point ``matrix`` of any shape (n, m), taken as exact."""
    return flint().arb_mat([[float(value) for value in row] for row in np.asarray(matrix)])


def lipschitz_bound(
    closed_loop: ClosedLoopBalls,
    weight: NDArray[np.float64],
    linear: NDArray[np.float64],
    constant: float,
    level: float,
) -> QuadraticBound:
    """|g(x)|_P <= constant |x|_P on X_f, (27), with g(x) = f(x, Kx) - A_K x.

    Args:
        closed_loop: f(x, K x).
        weight: P_rho, shape (5, 5).
        linear: A_K, shape (5, 5).
        constant: L [-].
        level: varrho [-].
    """
    right = exact(weight) * flint().arb(constant) ** 2
    return QuadraticBound(closed_loop, weight, right, level, linear)


def is_violated(bound: QuadraticBound, state: NDArray[np.float64]) -> bool:
    """Whether a state is surely a counterexample: x'Px <= level and the left side above the right.

    Args:
        bound: The inequality.
        state: x, shape (5,), taken as exact doubles.
    """
    module = flint()
    with module.ctx.workprec(PRECISION):
        x = [module.arb(float(value)) for value in state]
        column = module.arb_mat([[entry] for entry in x])
        value, _ = bound.closed_loop.value_and_jacobian(x)
        image = module.arb_mat([[entry] for entry in value])
        if bound.subtracted is not None:
            image = image - exact(bound.subtracted) * column
        weight = exact(bound.weight)
        left = (image.transpose() * weight * image)[0, 0]
        right = (column.transpose() * bound.right * column)[0, 0]
        height = (column.transpose() * weight * column)[0, 0]
        return bool(left > right) and bool(height <= module.arb(bound.level))
