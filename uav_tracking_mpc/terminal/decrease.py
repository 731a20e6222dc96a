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

r"""Does the optimal cost fall as (54) says? Checked online, step by step.

With a proved terminal set the argument of (49)-(51) gives, for the nominal model,

.. math:: V_N(x_{k+1}) \le V_N(x_k) - L(x_k, u_k) \le V_N(x_k) - \xi |x_k|_{P_\rho}^2

which is (54) with the constant xi of (52) in the place of c_3. What c_3 has besides, (rho - 1)
sigma - b, belongs to x_N in (35), not to x_k as (53) has it. What breaks it in flight is not the
theorem but one of its hypotheses, and which one is usually known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.ingredients import StabilityProblem, relative_eigenvalues

TOLERANCE = 1e-6  # -, relative to V_N(k) and to varrho: what a solver's own tolerance may add


@dataclass(frozen=True)
class DecreaseCheck:
    """One step.

    Attributes:
        held: V_N(k+1) is not above the bound.
        cost: V_N(k+1) [-].
        bound: Right side of (54) [-].
        reason: Why it failed, in words; "" where it held.
    """

    held: bool
    cost: float
    bound: float
    reason: str


class DecreaseMonitor:
    """Compares each optimal cost with the bound (54), with xi, that the step before implies.

    Args:
        problem: The configuration.
        level: varrho of the terminal set that the controller uses [-]; None if none is enforced.

    Attributes:
        rate: xi of (52) [-].
        weight: P_rho, shape (5, 5).
        level: As above.
        checked: How many steps were compared.
        failed: In how many of them the cost was above the bound.
    """

    def __init__(self, problem: StabilityProblem, level: float | None) -> None:
        self.weight, self.level = problem.ingredients().weight, level
        self.rate, *_ = map(float, relative_eigenvalues(problem.state_weight, self.weight))
        self.checked = self.failed = 0
        self._last: tuple[float, float, bool] | None = None

    def reset(self) -> None:
        """Forget the step before: after a fault, or when the reference changed."""
        self._last = None

    def after(self, other: DecreaseMonitor) -> DecreaseMonitor:
        """This monitor, which goes on with the counts of another one.

        Args:
            other: Of the orbit before.
        """
        self.checked, self.failed = other.checked, other.failed
        return self

    def step(
        self,
        cost: float,
        error: NDArray[np.float64],
        final_error: NDArray[np.float64] | None = None,
        *,
        target_moved: bool = False,
        fraction: float = 1.0,
    ) -> DecreaseCheck | None:
        """Take the result of one solve and compare it with the one before.

        Args:
            cost: V_N(x_k) [-].
            error: x_k, shape (5,).
            final_error: x_N of the plan, shape (5,), to see whether it ends in X_f.
            target_moved: The target has moved, or the wind changed, since the step before.
            fraction: Time since the step before over T_s [-]. Below 1 that share of the stage cost
                is asked for; (54) itself is proved for whole steps only.

        Returns:
            None at the first step and after one without a finite cost.
        """
        error = np.asarray(error, dtype=float)
        inside = self._ends_inside(final_error)
        previous, check = self._last, None
        if previous is not None and np.isfinite(cost):
            last_cost, fall, was_inside = previous
            bound = last_cost - min(max(fraction, 0.0), 1.0) * fall
            held = bool(cost <= bound + TOLERANCE * max(abs(last_cost), 1e-12))
            reason = "" if held else _reason(was_inside, target_moved)
            self.failed += not held
            self.checked += 1
            check = DecreaseCheck(held, float(cost), float(bound), reason)
        self._last = None
        if np.isfinite(cost):
            self._last = float(cost), self.rate * float(error @ self.weight @ error), inside
        return check

    def _ends_inside(self, final_error: NDArray[np.float64] | None) -> bool:
        if final_error is None or self.level is None:
            return False
        x = np.asarray(final_error, dtype=float)
        return bool(x @ self.weight @ x <= self.level * (1.0 + TOLERANCE))


def _reason(was_inside: bool, target_moved: bool) -> str:
    """The first hypothesis of Theorem 3 that is known to be broken."""
    if target_moved:
        return "target or wind moved: the bound holds for a target at rest"
    if not was_inside:
        return "terminal set not reached: the plan before did not end in X_f"
    return "unknown: disturbance, sampling or model error"
