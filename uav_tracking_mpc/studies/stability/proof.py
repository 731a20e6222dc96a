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

"""Proofs that x'P_rho x <= varrho is a terminal set, and of any quadratic bound on it.

The direct condition needs no constant L. For every x of X_f:

1. V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= 0: all that the proofs of Theorems 2 and 3 use. It makes
   X_f invariant under kappa_l and the optimal cost fall by at least the stage cost, (51);
2. K x + u_ss in U, (25);
3. r > |z|, so d > 0, and |x_2| < pi: the model is defined there.

1 is proved with a slack of a millionth of V_f, 2 and 3 with a margin of a millionth of the level,
so that P and K recomputed on another machine, equal to eleven digits but not to the last bit, are
covered too.

1 is a quadratic bound. Boxes are halved until each one passes its test. They form a tree: its root
holds X_f; a node is a box that was halved, a leaf one on which the bound is confirmed. Written in
preorder, one character a node (the coordinate that was halved, or a dot for a leaf), the tree is
the proof's certificate: it covers the root by construction, and whoever distrusts the search needs
only to test the leaves again. The search is plain floating point, all boxes of a size together;
what counts as proved is what the test in intervals (``terminal/quadratic_bound``) confirms.

2 and 3 are linear limits on the ellipsoid. The largest value of c'x over x'Px <= varrho is
sqrt(varrho c'P^-1 c), so a limit c'x < room holds on all of X_f exactly when
varrho c'P^-1 c < room^2. P^-1 is enclosed in intervals, hence the levels are proved.
"""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.vehicle import INPUT_NAMES
from uav_tracking_mpc.terminal.certificate import FORMAT, digest, problem_parameters
from uav_tracking_mpc.terminal.ingredients import StabilityProblem, TerminalIngredients
from uav_tracking_mpc.terminal.interval import Interval, exact, inverse_of, quadratic
from uav_tracking_mpc.terminal.quadratic_bound import (
    HALF_TURN,
    ClosedLoop,
    Expansion,
    Guess,
    QuadraticBound,
    decrease_bound,
    steady_intervals,
)

DEPTH_LIMIT = 80  # halvings of a box
BOXES = 20_000  # budget of a proof, ten seconds of an idle core; a loaded one finds the same, later
MULTIPLIER_STEPS = 14  # of a search for multipliers


@dataclass(frozen=True)
class Proof:
    """Outcome: proved, or not proved and why it stopped.

    It never says "false": only a counterexample does, and looking for one is not done here.

    Attributes:
        stuck: Why it stopped before the bound was proved, in words; None where it is proved.
        half: Half-widths of the root box, length 5 [m, rad, m, rad, m/s].
        tree: The boxes in preorder (empty unless proved).
        multipliers: m of the test on each leaf [-], in the order of the tree (empty unless
            proved).
        statistics: ``boxes`` tested, ``leaves``, on which the bound was proved, and ``depth``,
            largest number of halvings.
    """

    stuck: str | None
    half: tuple[float, ...]
    tree: str
    multipliers: tuple[float, ...]
    statistics: dict[str, int]

    @property
    def proved(self) -> bool:
        """Whether the bound holds for every x of X_f."""
        return self.stuck is None


def prove(bound: QuadraticBound, box_limit: int = BOXES) -> Proof:
    """Prove the bound on x' P x <= varrho.

    Args:
        bound: What to prove.
        box_limit: Give up after so many boxes.
    """
    root = bound.root()
    center, half, multipliers = np.zeros((1, len(root))), root[None], np.zeros(1)
    layers: list[tuple[NDArray[np.bool_], NDArray[np.intp], NDArray[np.float64]]] = []
    boxes, leaves, share, stuck = 0, 0, 0.0, None
    while len(center) and stuck is None:
        left = box_limit - boxes
        proved, cut, multipliers = verdicts(bound, center[:left], half[:left], multipliers[:left])
        boxes += len(proved)
        leaves += int(proved.sum())
        share += int(proved.sum()) * 0.5 ** len(layers)
        layers.append((proved, cut, multipliers))
        each = np.flatnonzero(~proved)
        width = half[each]
        width[np.arange(len(each)), cut[each]] /= 2.0
        shift = np.where(np.arange(len(root)) == cut[each][:, None], width, 0.0)
        lower, upper = center[each] - shift, center[each] + shift
        if len(each) and len(layers) > DEPTH_LIMIT:
            stuck = f"a box halved {DEPTH_LIMIT} times still fails: the bound is tight or false"
        elif len(center) > left or (len(each) and boxes >= box_limit):
            stuck = (
                f"the budget of {box_limit} boxes is spent, {share:.1%} of the volume "
                "proved; a larger one (--boxes) may do"
            )
        elif not (exact(center[each], shift, upper) and exact(center[each], -shift, lower)):
            stuck = "boxes got too small to be halved exactly: the bound is tight or false"
        center = np.stack([lower, upper], axis=1).reshape(-1, len(root))
        half, multipliers = np.repeat(width, 2, axis=0), np.repeat(multipliers[each], 2)
    tree, found = _in_preorder(layers) if stuck is None else ("", ())
    return Proof(
        stuck=stuck,
        half=tuple(root.tolist()),
        tree=tree,
        multipliers=found,
        statistics={"boxes": boxes, "leaves": leaves, "depth": len(layers) - 1},
    )


def verdicts(
    bound: QuadraticBound,
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    multipliers: NDArray[np.float64],
) -> tuple[NDArray[np.bool_], NDArray[np.intp], NDArray[np.float64]]:
    """Test boxes.

    Args:
        bound: What to prove.
        center: Their middles, shape (n, 5), taken as exact doubles.
        half: Their half-widths, shape (n, 5), likewise.
        multipliers: First guesses of m, shape (n,) [-].

    Returns:
        Where the bound is confirmed; else which coordinate to halve next; the m that was best. Of
        shape (n,) each.
    """
    expansion = bound.expansion(center, half)
    m, guess = _lowest(bound, center, half, expansion, multipliers)
    proved = bound.confirmed(center, half, m, expansion, guess)
    at_origin = np.all(np.abs(center) <= half, axis=1)
    proved[at_origin] = bound.holds_at_origin(center[at_origin], half[at_origin])
    weight = expansion.influence * 2.0 * guess.pull[:, None] + guess.convexifier * half**2
    return proved, np.argmax(weight, axis=1), m


def _lowest(
    bound: QuadraticBound,
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    expansion: Expansion,
    start: NDArray[np.float64],
) -> tuple[NDArray[np.float64], Guess]:
    """The m of each box at which the bound is lowest, and the guess there.

    The bound is convex in m with slope varrho - x'Px at its worst point: follow it.
    """
    m, low, high = start.copy(), np.zeros_like(start), np.full_like(start, np.inf)
    best, lowest = m.copy(), np.full_like(start, np.inf)
    expanded = expansion.in_floats()
    active = np.arange(len(m))
    level = bound.level
    for _ in range(MULTIPLIER_STEPS):
        a, jacobian, error = expanded
        chosen = a[active], jacobian[active], error[active]
        found = bound.guess(center[active], half[active], chosen, m[active])
        excess, height, now = found.excess, found.height, m[active]
        better = active[excess < lowest[active]]
        best[better] = m[better]
        lowest[active] = np.minimum(lowest[active], excess)
        above = height > level
        low[active], high[active] = np.where(above, (now, high[active]), (low[active], now))
        growing = above & np.isinf(high[active])
        # Where nothing within the bracket can bring it below 0, or the worst point lies inside X_f.
        with np.errstate(invalid="ignore"):
            hopeless = (high[active] - low[active]) * np.abs(height - level) < excess
        done = (excess < -1e-12 * (found.pull**2 + height)) | (
            np.abs(height - level) < 1e-4 * level
        )
        done |= np.where(growing, 4.0 * now > 1e3, hopeless | (now == 0.0))
        next_m = np.where(growing, np.maximum(0.03, 4.0 * now), 0.5 * (low[active] + high[active]))
        m[active] = np.where(done, now, next_m)
        active = active[~done]
        if not len(active):
            break
    best = np.array([float(f"{value:.6g}") for value in best])  # the certificate carries it
    return best, bound.guess(center, half, expanded, best)


def _in_preorder(
    layers: list[tuple[NDArray[np.bool_], NDArray[np.intp], NDArray[np.float64]]],
) -> tuple[str, tuple[float, ...]]:
    """Tree and multipliers of its leaves, from the boxes of each depth, halves side by side."""
    first = [2 * (np.cumsum(~proved) - 1) for proved, _, _ in layers]  # of a box's halves
    tree, found = [], []
    stack = [(0, 0)]
    while stack:
        depth, place = stack.pop()
        proved, cut, multipliers = layers[depth]
        if proved[place]:
            tree.append(".")
            found.append(float(multipliers[place]))
            continue
        tree.append(str(cut[place]))
        below = int(first[depth][place])
        stack += [(depth + 1, below + 1), (depth + 1, below)]
    return "".join(tree), tuple(found)


SLACK = 1e-6  # -, tolerance: relative, by which V_f must decrease more than it has to
MARGIN = 1e-6  # -, of a level below the one at which an input or the domain binds


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


def limits(problem: StabilityProblem, ingredients: TerminalIngredients) -> tuple[Limit, Limit]:
    """Of the bounds of U and of the limits of the model's domain those that bind first.

    Args:
        problem: Its orbit, model and input box.
        ingredients: K and P_rho, taken as exact.
    """
    _, u_ss = steady_intervals(problem.model, problem.orbit)
    inverse = inverse_of(ingredients.weight)

    def limit(name: str, room: Interval, c: ArrayLike) -> Limit:
        if not room.lower > 0.0:
            return Limit(name, 0.0)
        level = (room.square() / quadratic(inverse, Interval(c))).lower
        return Limit(name, float(level) * (1.0 - 1e-12))

    inputs = []
    for i, (name, row) in enumerate(zip(INPUT_NAMES, ingredients.gain, strict=True)):
        lower, upper = float(problem.input_lower[i]), float(problem.input_upper[i])
        inputs.append(limit(f"lower bound of {name}", u_ss[i] - lower, row))
        inputs.append(limit(f"upper bound of {name}", upper - u_ss[i], row))
    range_, altitude = Interval(problem.orbit.range), problem.orbit.altitude
    domain = [
        limit("range above the height over the target, r > z", range_ - altitude, (1, 0, -1, 0, 0)),
        limit("range above the depth below the target, r > -z", range_ + altitude, (1, 0, 1, 0, 0)),
        limit("bearing error below half a turn, |x_2| < pi", HALF_TURN, (0, 1, 0, 0, 0)),
    ]
    binding = attrgetter("level")
    return min(inputs, key=binding), min(domain, key=binding)


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
            return f"not proved: decrease of V_f, {self.decrease.stuck}"
        return "proved"


def allowed_level(*limits: Limit) -> float:
    """The largest level [-] that stays below some ``limits`` by the margin."""
    return min(limit.level for limit in limits) * (1.0 - MARGIN)


def decrease(
    problem: StabilityProblem, ingredients: TerminalIngredients, level: float
) -> QuadraticBound:
    """Part 1 at one level, as the inequality to prove.

    Args:
        problem: The configuration.
        ingredients: K and P_rho, taken as exact.
        level: varrho [-].
    """
    weights = ingredients.weight, problem.state_weight, problem.input_weight
    return decrease_bound(
        closed_loop(problem, ingredients), *weights, ingredients.gain, SLACK, level
    )


def closed_loop(problem: StabilityProblem, ingredients: TerminalIngredients) -> ClosedLoop:
    """f(x, K x) of a configuration, with its derivatives, in intervals.

    Args:
        problem: The configuration.
        ingredients: K, taken as exact.
    """
    return ClosedLoop(problem.model, problem.scheme, problem.orbit, problem.step, ingredients.gain)


def lipschitz_bound(
    problem: StabilityProblem, ingredients: TerminalIngredients, constant: float, level: float
) -> QuadraticBound:
    """|g(x)|_P <= constant |x|_P on X_f, (27), with g(x) = f(x, Kx) - A_K x.

    Args:
        problem: The configuration.
        ingredients: K, P_rho and A_K, taken as exact.
        constant: L [-].
        level: varrho [-].
    """
    weight = ingredients.weight
    right = Interval(constant).square() * weight
    loop = closed_loop(problem, ingredients)
    return QuadraticBound(loop, weight, right, level, ingredients.closed_loop)


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
        box_limit: See :func:`uav_tracking_mpc.studies.stability.proof.prove`.
    """
    bound = decrease(problem, ingredients, level)
    inputs, domain = limits(problem, ingredients)
    return DirectCondition(level, prove(bound, box_limit), inputs, domain)


def certificate(
    problem: StabilityProblem, ingredients: TerminalIngredients, proved: DirectCondition
) -> dict[str, Any]:
    """Write a proved direct condition down.

    Args:
        problem: The configuration.
        ingredients: Its K and P_rho.
        proved: What was proved of them.

    Raises:
        ValueError: It is not proved.
    """
    if not proved.holds:
        raise ValueError(f"no certificate at level {proved.level:.6g}: {proved.reason}")
    proof = proved.decrease
    content: dict[str, Any] = {
        "format": FORMAT,
        "problem": problem_parameters(problem),
        "gain": ingredients.gain.tolist(),
        "weight": ingredients.weight.tolist(),
        "level": float(proved.level),
        "slack": SLACK,
        "root": list(proof.half),
        "tree": proof.tree,
        "multipliers": list(proof.multipliers),
        "statistics": proof.statistics,
        "versions": _versions(),
    }
    content["digest"] = digest(content)
    return content


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in ("uav_tracking_mpc", "casadi", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    return found
