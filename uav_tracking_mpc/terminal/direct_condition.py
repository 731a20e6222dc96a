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

"""The direct condition: what makes x'P_rho x <= varrho a terminal set, proved without a constant L.

For every x of X_f:

1. V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= 0: all that the proofs of Theorems 2 and 3 use. It makes
   X_f invariant under kappa_l and the optimal cost fall by at least the stage cost, (51);
2. K x + u_ss in U, (25);
3. r > |z|, so d > 0, and |x_2| < pi: the model is defined there.

1 is proved with a slack of a millionth of V_f, 2 and 3 with a margin of a millionth of the level,
so that P and K recomputed on another machine, equal to eleven digits but not to the last bit, are
covered too.
"""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.terminal.admissible import Limit, domain_limits, input_limits, lowest
from uav_tracking_mpc.terminal.ball import PRECISION, flint
from uav_tracking_mpc.terminal.cover import BOXES, Proof, prove
from uav_tracking_mpc.terminal.ingredients import TerminalIngredients
from uav_tracking_mpc.terminal.quadratic_bound import QuadraticBound, exact
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.terminal_dynamics import ClosedLoopBalls

SLACK = 1e-6
MARGIN = 1e-6  # of a level below the one at which an input or the domain binds


@dataclass(frozen=True)
class DirectCondition:
    """The three parts at one level.

    Attributes:
        level: varrho [-].
        decrease: Proof of part 1.
        inputs: The input limit that binds first.
        domain: The domain limit that binds first.
    """

    level: float
    decrease: Proof
    inputs: Limit
    domain: Limit

    @property
    def holds(self) -> bool:
        """Whether all three parts are proved."""
        return self.decrease.proved and self.level <= allowed_level(self.inputs, self.domain)

    @property
    def reason(self) -> str:
        """Proved, or what is in the way, in words."""
        if allowed_level(self.domain) < self.level:
            return f"not proved: {self.domain.name} only up to level {self.domain.level:.6g}"
        if allowed_level(self.inputs) < self.level:
            return f"not proved: {self.inputs.name} binds at level {self.inputs.level:.6g}"
        if self.decrease.stuck is not None:
            return f"not proved: decrease of V_f, {self.decrease.stuck.reason}"
        return "proved"


def allowed_level(*limits: Limit) -> float:
    """The largest level [-] that stays below some ``limits`` by the margin."""
    return lowest(list(limits)).level * (1.0 - MARGIN)


def decrease(
    problem: StabilityProblem, ingredients: TerminalIngredients, level: float
) -> QuadraticBound:
    """Part 1 at one level, as the inequality to prove.

    Args:
        problem: The configuration.
        ingredients: K and P_rho, taken as exact.
        level: varrho [-].
    """
    loop = ClosedLoopBalls(
        problem.model, problem.scheme, problem.orbit, problem.step, ingredients.gain
    )
    with flint().ctx.workprec(PRECISION):
        k = exact(ingredients.gain)
        stage = exact(problem.state_weight) + k.transpose() * exact(problem.input_weight) * k
        right = exact(ingredients.weight) * (1 - flint().arb(SLACK)) - stage
        return QuadraticBound(loop, ingredients.weight, right, level)


def prove_direct_condition(
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    level: float,
    box_limit: int = BOXES,
) -> DirectCondition:
    """Prove that x'P_rho x <= level is a terminal set of the configuration.

    Args:
        problem: The configuration.
        ingredients: K and P_rho, taken as exact.
        level: varrho [-].
        box_limit: See :func:`uav_tracking_mpc.terminal.cover.prove`.
    """
    bound = decrease(problem, ingredients, level)
    return DirectCondition(
        level=level,
        decrease=prove(bound, box_limit),
        inputs=lowest(input_limits(problem, ingredients.gain, ingredients.weight)),
        domain=lowest(domain_limits(problem, ingredients.weight)),
    )
