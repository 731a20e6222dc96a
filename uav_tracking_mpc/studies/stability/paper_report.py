"""The paper beside the truth: every number it prints, recomputed three times, with a verdict.

Columns: as printed; with the printed A (58) in the place of a linearisation (the plant is (11));
with (11) and its own Jacobian; with the exact kinematics. Nothing numerical is typed in except
what the paper prints (``printed``): verdicts compare numbers and try formulas that might explain
a misprint.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.studies.stability import printed
from uav_tracking_mpc.studies.stability.distance_budget import distance_budget
from uav_tracking_mpc.terminal.ingredients import (
    TerminalIngredients,
    input_limited_level,
    terminal_ingredients,
)
from uav_tracking_mpc.terminal.stability_problem import (
    PAPER_INITIAL_STATE,
    StabilityProblem,
    paper_problem,
)
from uav_tracking_mpc.terminal.theorems import (
    largest_lipschitz,
    q_star,
    theorem_quantities,
)
from uav_tracking_mpc.terminal.violation import Excess, largest_ratio, lowest_violation

COLUMNS = ("printed", "printed_A", "model_11", "exact")


@dataclass(frozen=True)
class Row:
    """One quantity.

    Attributes:
        name: What it is.
        equation: Where the paper prints it.
        printed: As printed, in the unit of the quantity [SI], or None.
        printed_A: Recomputed with (58), in [SI], or None where it makes no sense.
        model_11: Recomputed with (11), in [SI].
        exact: Recomputed with the exact kinematics, in [SI].
        verdict: In words.
    """

    name: str
    equation: str
    printed: float | None
    printed_A: float | None  # noqa: N815 (the symbol of the paper)
    model_11: float | None
    exact: float | None
    verdict: str


@dataclass(frozen=True)
class _Case:
    """One way to recompute: a plant, and the A that ingredients and g are made with."""

    problem: StabilityProblem
    ingredients: TerminalIngredients
    linearisation: NDArray[np.float64]

    def excess(self, right: NDArray[np.float64], lipschitz: bool) -> Excess:
        parts = self.ingredients
        return Excess(
            self.problem.dynamics(),
            parts.gain,
            parts.weight,
            right,
            parts.closed_loop if lipschitz else None,
        )

    def lipschitz(self, level: float) -> float:
        weight = self.ingredients.weight
        return largest_ratio(self.excess(0.0 * weight, True), level).level


@functools.cache
def paper_report() -> tuple[Row, ...]:
    """Recompute everything that Sections 3, 5 and 6 print: some seconds, the first time."""
    return (*_linearisation_rows(), *_theorem_rows(), *_simulation_rows())


def _cases() -> list[_Case]:
    plant = paper_problem("paper")
    by_hand = terminal_ingredients(
        printed.PRINTED_A,
        printed.PRINTED_B,
        plant.state_weight,
        plant.input_weight,
        plant.scaling,
    )
    cases = [_Case(plant, by_hand, printed.PRINTED_A)]
    for model in ("paper", "exact"):
        problem = paper_problem(model)
        cases.append(_Case(problem, problem.ingredients(), problem.linearisation()[0]))
    return cases


def _linearisation_rows() -> list[Row]:
    exact = paper_problem()
    orbit = exact.orbit
    symbolic = printed.symbolic_a(orbit.range, orbit.altitude, orbit.speed, exact.step)
    by_11, truth = (paper_problem(m).linearisation()[0] + 0.0 for m in ("paper", "exact"))
    rows = []
    for i, j in ((0, 1), (0, 3), (1, 0), (1, 2), (1, 3), (1, 4), (2, 3)):
        values = printed.PRINTED_A[i, j], symbolic[i, j], by_11[i, j], truth[i, j]
        rows.append(
            Row(
                f"A[{i},{j}]",
                "(58), (12)",
                float(values[0]),
                float(values[1]),
                float(values[2]),
                float(values[3]),
                _entry_verdict(*(float(v) for v in values)),
            )
        )
    turns = [float(steady_inputs(model, orbit)[0]) for model in ("paper", "paper9", "exact")]
    ratio = turns[0] / turns[2] - 1.0
    rows.append(
        Row(
            "steady u_psi [rad/s]",
            "Section 3.1",
            -orbit.speed / orbit.range,
            None,
            turns[0],
            turns[2],
            f"three models, three turns: (9b) gives {turns[1]:.6f}; (11) turns {abs(ratio):.1%} "
            f"{'slower' if abs(turns[0]) < abs(turns[2]) else 'faster'} than the true circle "
            "needs, so a controller built on it holds a range offset",
        )
    )
    return rows


def _entry_verdict(numeric: float, symbolic: float, model: float, exact: float) -> str:
    def same(a: float, b: float) -> bool:
        return abs(a - b) <= 0.51e-4 + 1e-12

    parts = []
    if not same(numeric, symbolic):
        parts.append(f"(12) evaluates to {symbolic:.4g}, (58) prints {numeric:.4g}")
    if not same(numeric, model):
        parts.append(f"the Jacobian of (11) is {model:.4g}")
    if not same(numeric, exact):
        parts.append(f"the true value is {exact:.4g}")
    return "; ".join(parts) if parts else "agrees to the digits printed"


def _theorem_rows() -> list[Row]:
    cases = _cases()
    found = [
        theorem_quantities(
            case.ingredients,
            case.problem.state_weight,
            case.problem.input_weight,
            printed.PRINTED_LIPSCHITZ,
            case.problem.horizon,
        )
        for case in cases
    ]
    rows = []

    def add(
        name: str, equation: str, stated: float | None, values: list[float], verdict: str
    ) -> None:
        rows.append(Row(name, equation, stated, values[0], values[1], values[2], verdict))

    for name, equation, attribute in (
        ("sigma", "Theorem 2", "sigma"),
        ("xi", "Theorem 3", "xi"),
        ("|A_K|_P", "(33)", "contraction"),
    ):
        add(name, equation, None, [getattr(q, attribute) for q in found], "not printed")

    left = [q.theorem3.left for q in found]
    add(
        "xi + (rho - 1) sigma",
        "(41)",
        printed.PRINTED_LEFT_41,
        left,
        _numeric_verdict(printed.PRINTED_LEFT_41, left),
    )
    right = [q.theorem3.right for q in found]
    square = printed.PRINTED_LIPSCHITZ**2
    verdict = _numeric_verdict(printed.PRINTED_RIGHT_41, right)
    if abs(square / printed.PRINTED_RIGHT_41 - 1.0) < 0.01:
        verdict += (
            f"; L^2 alone is {square:.4f}: the cross term 2 L |A_K|_P was left out of the sum"
        )
    add("b = 2 L |A_K|_P + L^2, L as printed", "(41)", printed.PRINTED_RIGHT_41, right, verdict)
    factors = [b / a for a, b in zip(left, right, strict=True)]
    add(
        "right over left of (41), holds if at most 1",
        "(41)",
        printed.PRINTED_RIGHT_41 / printed.PRINTED_LEFT_41,
        factors,
        f"the printed certificate does not hold: (41) fails by a factor of {min(factors):.1f}"
        if min(factors) > 1.0
        else "holds",
    )
    for level in (printed.PRINTED_LEVEL_60, printed.PRINTED_LEVEL_TABLE):
        values = [case.lipschitz(level) for case in cases]
        add(
            f"L at varrho = {level}",
            "(31), Table 1",
            printed.PRINTED_LIPSCHITZ,
            values,
            _numeric_verdict(printed.PRINTED_LIPSCHITZ, values, tolerance=0.02),
        )
    turn_only = []
    for case in cases:
        bounds = np.full(3, 1e3)
        bounds[0] = np.pi / 4.0  # taken about the steady input, as a box symmetric in u - u_ss
        turn_only.append(input_limited_level(case.ingredients, -bounds, bounds))
    add(
        "varrho if |u_psi - u_ss| <= pi/4 alone",
        "(60), (25)",
        printed.PRINTED_LEVEL_60,
        turn_only,
        "U is never printed; "
        + _numeric_verdict(printed.PRINTED_LEVEL_60, turn_only, tolerance=0.02)
        + f"; Table 1 prints {printed.PRINTED_LEVEL_TABLE} for the same quantity",
    )
    whole = [
        input_limited_level(case.ingredients, *case.problem.deviation_bounds()) for case in cases
    ]
    add(
        "varrho for U = (pi/4, pi/4, 1)",
        "(25)",
        printed.PRINTED_LEVEL_60,
        whole,
        "about the steady input, all three bounds: "
        + _numeric_verdict(printed.PRINTED_LEVEL_60, whole, tolerance=0.02),
    )
    rows.extend(_reach_rows(cases, left))
    wrong_upper = [q.a_2 for q in found]
    add(
        "a_2 = lambda_max(P)",
        "Theorem 2",
        None,
        wrong_upper,
        f"V_f is |x|^2 in P_rho = rho P, so (2b) needs {2.5 * wrong_upper[-1]:.4g} (exact)",
    )
    add(
        "gamma = 1 - a_3 / a_2, L as printed",
        "(38)",
        None,
        [q.gamma for q in found],
        "(38)-(40) mix norms: V_f is |x|^2 in P_rho, so (37) gives 1 - a_3 directly; "
        + ("gamma > 1 here, nothing decreases" if found[-1].gamma > 1.0 else "gamma is looser"),
    )
    add(
        "c_3, L as printed",
        "(53), (57)",
        None,
        [q.c_3 for q in found],
        ("negative: (54) bounds nothing; " if found[-1].c_3 < 0.0 else "")
        + "(57) prints c_2/c_3 where the argument needs c_2 over a lower bound of V_N",
    )
    return rows


def _reach_rows(cases: list[_Case], left: list[float]) -> list[Row]:
    """Largest levels: of (41) with L(varrho), and of the decrease itself."""
    theorem3: list[float | None] = []
    decrease: list[float | None] = []
    for case, allowance in zip(cases, left, strict=True):
        parts = case.ingredients
        contraction = theorem_quantities(
            parts, case.problem.state_weight, case.problem.input_weight, 0.0, 1
        ).contraction
        limit = largest_lipschitz(contraction, allowance)
        third = lowest_violation(case.excess(limit**2 * parts.weight, True), 15.0)
        star = q_star(case.problem.state_weight, case.problem.input_weight, parts.gain)
        itself = lowest_violation(case.excess(parts.weight - star, False), 18.0)
        theorem3.append(None if third is None else third.level)
        decrease.append(None if itself is None else itself.level)
    mismatch = float(np.abs(printed.PRINTED_A - cases[1].linearisation).max())
    theorem3[0] = decrease[0] = None
    gain = float(decrease[2] or 0.0) / float(theorem3[2] or 1.0)
    return [
        Row(
            "varrho where (41) stops holding",
            "(31), (41)",
            printed.PRINTED_LEVEL_60,
            theorem3[0],
            theorem3[1],
            theorem3[2],
            f"the printed set is {printed.PRINTED_LEVEL_60 / float(theorem3[1] or 1.0):.0f} times "
            f"the level at which (41) stops for (11); with the printed A, wrong by up to "
            f"{mismatch:.3g}, g has a linear part and L does not vanish with varrho",
        ),
        Row(
            "varrho where the decrease stops",
            "(30)",
            printed.PRINTED_LEVEL_60,
            decrease[0],
            decrease[1],
            decrease[2],
            f"checked directly, without L, the decrease reaches {gain:.0f} times further (exact): "
            "the printed level is a terminal set after all, as far as the decrease goes"
            if (decrease[1] or 0.0) > printed.PRINTED_LEVEL_60
            else "the printed level is beyond it",
        ),
    ]


def _simulation_rows() -> list[Row]:
    rows = []
    budgets = {}
    for horizon in (10, 20):
        problem = replace(paper_problem(), horizon=horizon)
        budgets[horizon] = distance_budget(problem, PAPER_INITIAL_STATE, printed.PRINTED_LEVEL_60)
    needed, flown = budgets[10]
    rows.append(
        Row(
            "range that can be flown from x_o in N = 10 steps [m]",
            "(16e), Section 6",
            None,
            None,
            None,
            flown,
            f"the terminal set begins {needed:.2f} m from x_o: "
            + (
                "(16e) is infeasible, the published run cannot have enforced it"
                if flown < needed
                else "not excluded"
            )
            + f"; in 20 steps {budgets[20][1]:.0f} m can be flown",
        )
    )
    rows.append(
        Row(
            "initial speed [m/s]",
            "Section 6",
            float(PAPER_INITIAL_STATE[4]),
            None,
            None,
            None,
            "x_o is the actual state, not the error; a speed of 0 is below any stall speed",
        )
    )
    return rows


def _numeric_verdict(stated: float, values: list[float], tolerance: float = 0.002) -> str:
    names = ("the printed A", "(11)", "the exact model")
    differences = [value / stated - 1.0 for value in values]
    matching = [n for n, d in zip(names, differences, strict=True) if abs(d) <= tolerance]
    if matching:
        return f"reproduced within {tolerance:.1%} with {' and '.join(matching)}"
    best = int(np.argmin(np.abs(differences)))
    return (
        f"not reproduced: the nearest, with {names[best]}, is {values[best]:.4g}, "
        f"{values[best] / stated:.2f} times the printed value"
    )


def paper_as_printed() -> dict[str, Any]:
    """Whether (41) holds with the paper's own A, weights, rho and L."""
    case = _cases()[0]
    quantities = theorem_quantities(
        case.ingredients,
        case.problem.state_weight,
        case.problem.input_weight,
        printed.PRINTED_LIPSCHITZ,
        case.problem.horizon,
    )
    return quantities.theorem3.as_dict()
