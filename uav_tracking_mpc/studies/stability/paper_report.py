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

"""The paper beside the truth: every number it prints, recomputed three times, with a verdict.

Columns: as printed; with the printed A (58) in the place of a linearisation (the plant is (11));
with (11) and its own Jacobian; with the exact kinematics. Nothing numerical is typed in except
what the paper prints (``PRINTED``): verdicts compare numbers and try formulas that might explain
a misprint.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.stability.analysis import (
    Quantities,
    largest_lipschitz,
    largest_ratio,
    lipschitz_excess,
    lowest_violation,
    theorem3,
    theorem_quantities,
)
from uav_tracking_mpc.terminal.ingredients import (
    PAPER_INITIAL_STATE,
    StabilityProblem,
    TerminalIngredients,
    decrease_excess,
    input_limited_level,
    paper_problem,
    terminal_ingredients,
)

PRINTED_A = np.array(
    [
        [1.0, 4.0, 0.0, 4.0, 0.0],
        [-0.0002, 1.0, 0.0001, -0.0302, 0.0075],
        [0.0, 0.0, 1.0, 4.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0],
    ]
)  # (58)
PRINTED_B = np.array(
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
)  # (58)
PRINTED_LEVEL_60 = 3.1733  # (60)
PRINTED_LEVEL_TABLE = 3.2649  # Table 1
PRINTED_LIPSCHITZ = 0.5265  # Table 1
PRINTED_LEFT_41 = 0.2782  # (41), xi + (rho - 1) sigma, printed after (60)
PRINTED_RIGHT_41 = 0.2762  # (41), 2 L |A_K| + L^2, printed after (60)


def symbolic_a(orbit: Orbit, step: float) -> np.ndarray:
    """A of (12) evaluated on an orbit with T_s in [s], shape (5, 5)."""
    range_, altitude, speed = orbit.range, orbit.altitude, orbit.speed
    square = range_**2 - altitude**2
    a = np.eye(5)
    a[0, 1] = a[0, 3] = a[1, 0] = a[2, 3] = step * speed
    a[1, 2] = 2.0 * step * speed * range_ * altitude / square**2
    a[1, 3] = step * speed * range_ / square
    a[1, 4] = step * range_ / square
    return a


def distance_budget(
    problem: StabilityProblem, state: NDArray[np.float64], level: float
) -> tuple[float, float]:
    """Range to cover to reach X_f, and an upper bound for what can be flown in N steps.

    Each Euler step changes r by at most T_s v, and v is limited by the acceleration from the start
    and by the speeds that X_f holds at the end.

    Args:
        problem: Horizon, step, input bounds, weights.
        state: (r, theta, z, chi, v), shape (5,).
        level: varrho [-].

    Returns:
        (needed, possible), in [m]. needed > possible proves that (16e) is infeasible.
    """
    inverse = np.linalg.inv(problem.ingredients().weight)
    range_extent, _, _, _, speed_extent = np.sqrt(level * np.diag(inverse))
    r, _, _, _, v = state
    needed = abs(float(r) - problem.orbit.range) - float(range_extent)
    k = np.arange(problem.horizon)
    _, _, up = problem.step * problem.input_upper
    _, _, down = -problem.step * problem.input_lower
    last = problem.orbit.speed + float(speed_extent)
    speeds = np.minimum(v + k * up, last + (problem.horizon - k) * down)
    return needed, float(problem.step * np.maximum(speeds, 0.0).sum())


class PaperCase(NamedTuple):
    """One way to recompute: the plant, and what belongs to one of its linearisations.

    Attributes:
        problem: The plant.
        ingredients: Made with ``linearisation``.
        linearisation: A, shape (5, 5).
    """

    problem: StabilityProblem
    ingredients: TerminalIngredients
    linearisation: NDArray[np.float64]

    def quantities(self, lipschitz: float) -> Quantities:
        """Theorems 2 and 3 with L [-]."""
        return theorem_quantities(self.problem, self.ingredients, lipschitz)


@functools.cache
def paper_cases() -> tuple[PaperCase, ...]:
    """In the order of the columns: with the printed A, with (11), with the exact kinematics."""
    plant = paper_problem("paper")
    weights = (plant.state_weight, plant.input_weight, plant.scaling)
    printed = terminal_ingredients(PRINTED_A, PRINTED_B, *weights)
    return (
        PaperCase(plant, printed, PRINTED_A),
        *(
            PaperCase(problem, problem.ingredients(), problem.linearisation()[0])
            for problem in map(paper_problem, ("paper", "exact"))
        ),
    )


# One quantity: its ``name``; the ``equation``, where the paper prints it; in [SI], or None where
# there is none: as ``printed``, recomputed with (58) as ``printed_A``, with (11) as ``model_11``,
# and with the ``exact`` kinematics; the ``verdict`` in words.
Row = dict[str, Any]


@functools.cache
def paper_report() -> tuple[Row, ...]:
    """Recompute everything that Sections 3, 5 and 6 print: some seconds, the first time."""
    return (*_linearisation_rows(), *_theorem_rows(), *_simulation_rows())


def _row(
    name: str, equation: str, stated: float | None, values: Sequence[float | None], verdict: str
) -> Row:
    by_a, by_11, exact = (None if value is None else float(value) for value in values)
    return {
        "name": name,
        "equation": equation,
        "printed": stated,
        "printed_A": by_a,
        "model_11": by_11,
        "exact": exact,
        "verdict": verdict,
    }


def _linearisation_rows() -> list[Row]:
    exact = paper_problem()
    orbit = exact.orbit
    symbolic = symbolic_a(orbit, exact.step)
    _, by_11, truth = (case.linearisation + 0.0 for case in paper_cases())
    rows = []
    for entry in ((0, 1), (0, 3), (1, 0), (1, 2), (1, 3), (1, 4), (2, 3)):
        stated = float(PRINTED_A[entry])
        values = [float(matrix[entry]) for matrix in (symbolic, by_11, truth)]
        name = f"A[{entry[0]},{entry[1]}]"
        rows.append(_row(name, "(58), (12)", stated, values, _entry_verdict(stated, *values)))
    by_11_turn, by_9_turn, turn = (
        float(steady_inputs(model, orbit)[0]) for model in ("paper", "paper9", "exact")
    )
    verdict = (
        f"three models, three turns: (9b) gives {by_9_turn:.6f}; (11) turns "
        f"{abs(by_11_turn / turn - 1.0):.1%} "
        f"{'slower' if abs(by_11_turn) < abs(turn) else 'faster'} than the true circle "
        "needs, so a controller built on it holds a range offset"
    )
    stated, turns = -orbit.speed / orbit.range, (None, by_11_turn, turn)
    return [*rows, _row("steady u_psi [rad/s]", "Section 3.1", stated, turns, verdict)]


def _entry_verdict(numeric: float, symbolic: float, model: float, exact: float) -> str:
    claims = (
        (symbolic, f"(12) evaluates to {symbolic:.4g}, (58) prints {numeric:.4g}"),
        (model, f"the Jacobian of (11) is {model:.4g}"),
        (exact, f"the true value is {exact:.4g}"),
    )
    wrong = [words for value, words in claims if abs(numeric - value) > 0.51e-4 + 1e-12]
    return "; ".join(wrong) or "agrees to the digits printed"


def _theorem_rows() -> list[Row]:
    cases = paper_cases()
    found = [case.quantities(PRINTED_LIPSCHITZ) for case in cases]
    left, right = ([theorem3(q)[side] for q in found] for side in ("left", "right"))
    factors = [b / a for a, b in zip(left, right, strict=True)]
    square = PRINTED_LIPSCHITZ**2
    cross_term = ""
    if abs(square / PRINTED_RIGHT_41 - 1.0) < 0.01:
        cross_term = (
            f"; L^2 alone is {square:.4f}: the cross term 2 L |A_K|_P was left out of the sum"
        )
    *_, exact = found
    return [
        _row("sigma", "Theorem 2", None, [q["sigma"] for q in found], "not printed"),
        _row("xi", "Theorem 3", None, [q["xi"] for q in found], "not printed"),
        _row("|A_K|_P", "(33)", None, [q["contraction"] for q in found], "not printed"),
        _compared("xi + (rho - 1) sigma", "(41)", PRINTED_LEFT_41, left),
        _compared(
            "b = 2 L |A_K|_P + L^2, L as printed", "(41)", PRINTED_RIGHT_41, right, after=cross_term
        ),
        _row(
            "right over left of (41), holds if at most 1",
            "(41)",
            PRINTED_RIGHT_41 / PRINTED_LEFT_41,
            factors,
            f"the printed certificate does not hold: (41) fails by a factor of {min(factors):.1f}"
            if min(factors) > 1.0
            else "holds",
        ),
        *_level_rows(),
        *_reach_rows(left),
        _row(
            "a_2 = lambda_max(P)",
            "Theorem 2",
            None,
            [q["a_2"] for q in found],
            f"V_f is |x|^2 in P_rho = rho P, so (2b) needs "
            f"{cases[-1].problem.scaling * exact['a_2']:.4g} (exact)",
        ),
        _row(
            "gamma = 1 - a_3 / a_2, L as printed",
            "(38)",
            None,
            [q["gamma"] for q in found],
            "(38)-(40) mix norms: V_f is |x|^2 in P_rho, so (37) gives 1 - a_3 directly; "
            + ("gamma > 1 here, nothing decreases" if exact["gamma"] > 1.0 else "gamma is looser"),
        ),
        _row(
            "c_3, L as printed",
            "(53), (57)",
            None,
            [q["c_3"] for q in found],
            ("negative: (54) bounds nothing; " if exact["c_3"] < 0.0 else "")
            + "(57) prints c_2/c_3 where the argument needs c_2 over a lower bound of V_N",
        ),
    ]


def _level_rows() -> list[Row]:
    """Lipschitz constants at the printed levels, and the levels that U allows."""
    cases, rows = paper_cases(), []
    for level in (PRINTED_LEVEL_60, PRINTED_LEVEL_TABLE):
        values = [
            largest_ratio(lipschitz_excess(case.problem, case.ingredients, 0.0), level).level
            for case in cases
        ]
        name = f"L at varrho = {level}"
        rows.append(_compared(name, "(31), Table 1", PRINTED_LIPSCHITZ, values, 0.02))
    turn, _, _ = paper_numbers.INPUT_BOUNDS
    bounds = np.array([turn, 1e3, 1e3])  # about the steady input, as a box symmetric in u - u_ss
    turn_only = [input_limited_level(case.ingredients, -bounds, bounds) for case in cases]
    whole = [
        input_limited_level(case.ingredients, *case.problem.deviation_bounds()) for case in cases
    ]
    return [
        *rows,
        _compared(
            "varrho if |u_psi - u_ss| <= pi/4 alone",
            "(60), (25)",
            PRINTED_LEVEL_60,
            turn_only,
            0.02,
            "U is never printed; ",
            f"; Table 1 prints {PRINTED_LEVEL_TABLE} for the same quantity",
        ),
        _compared(
            "varrho for U = (pi/4, pi/4, 1)",
            "(25)",
            PRINTED_LEVEL_60,
            whole,
            0.02,
            "about the steady input, all three bounds: ",
        ),
    ]


def _reach_rows(left: list[float]) -> list[Row]:
    """Largest levels: of (41) with L(varrho), and of the decrease itself."""
    _, model_11, _ = cases = paper_cases()
    theorem3: list[float | None] = [None]  # with the printed A neither makes sense
    decrease: list[float | None] = [None]
    for case, allowance in list(zip(cases, left, strict=True))[1:]:
        parts = case.problem, case.ingredients
        limit = largest_lipschitz(case.quantities(0.0)["contraction"], allowance)
        third = lowest_violation(lipschitz_excess(*parts, limit), 15.0)
        itself = lowest_violation(decrease_excess(*parts), 18.0)
        theorem3.append(None if third is None else third.level)
        decrease.append(None if itself is None else itself.level)
    mismatch = float(np.abs(PRINTED_A - model_11.linearisation).max())
    gain = float(decrease[2] or 0.0) / float(theorem3[2] or 1.0)
    level = PRINTED_LEVEL_60
    return [
        _row(
            "varrho where (41) stops holding",
            "(31), (41)",
            level,
            theorem3,
            f"the printed set is {level / float(theorem3[1] or 1.0):.0f} times "
            f"the level at which (41) stops for (11); with the printed A, wrong by up to "
            f"{mismatch:.3g}, g has a linear part and L does not vanish with varrho",
        ),
        _row(
            "varrho where the decrease stops",
            "(30)",
            level,
            decrease,
            f"checked directly, without L, the decrease reaches {gain:.0f} times further (exact): "
            "the printed level is a terminal set after all, as far as the decrease goes"
            if (decrease[1] or 0.0) > level
            else "the printed level is beyond it",
        ),
    ]


def _simulation_rows() -> list[Row]:
    (needed, flown), (_, flown_in_20) = (
        distance_budget(
            replace(paper_problem(), horizon=horizon), PAPER_INITIAL_STATE, PRINTED_LEVEL_60
        )
        for horizon in (10, 20)
    )
    outcome = "not excluded"
    if flown < needed:
        outcome = "(16e) is infeasible, the published run cannot have enforced it"
    *_, speed = PAPER_INITIAL_STATE
    return [
        _row(
            "range that can be flown from x_o in N = 10 steps [m]",
            "(16e), Section 6",
            None,
            (None, None, flown),
            f"the terminal set begins {needed:.2f} m from x_o: {outcome}"
            f"; in 20 steps {flown_in_20:.0f} m can be flown",
        ),
        _row(
            "initial speed [m/s]",
            "Section 6",
            float(speed),
            (None, None, None),
            "x_o is the actual state, not the error; a speed of 0 is below any stall speed",
        ),
    ]


def _compared(
    name: str,
    equation: str,
    stated: float,
    values: list[float],
    tolerance: float = 0.002,
    before: str = "",
    after: str = "",
) -> Row:
    """A row whose verdict says whether a printed number is reproduced."""
    names = ("the printed A", "(11)", "the exact model")
    differences = [value / stated - 1.0 for value in values]
    matching = [n for n, d in zip(names, differences, strict=True) if abs(d) <= tolerance]
    best = int(np.argmin(np.abs(differences)))
    verdict = (
        f"reproduced within {tolerance:.1%} with {' and '.join(matching)}"
        if matching
        else f"not reproduced: the nearest, with {names[best]}, is {values[best]:.4g}, "
        f"{values[best] / stated:.2f} times the printed value"
    )
    return _row(name, equation, stated, values, before + verdict + after)


def paper_as_printed() -> dict[str, Any]:
    """Whether (41) holds with the paper's own A, weights, rho and L."""
    return theorem3(paper_cases()[0].quantities(PRINTED_LIPSCHITZ))


HEADINGS = ("quantity", "where", "printed", "printed A", "with (11)", "exact", "verdict")

_INTRODUCTION = """# Errata of the paper

This page recomputes every number that Sections 3, 5 and 6 of the paper print. The main
results: the printed certificate fails its own condition (41) by a factor of 4.8; the published
simulation cannot have enforced the terminal constraint (16e); the printed terminal level is
nevertheless inside the region in which the terminal cost decreases.

`uav_tracking stability --errata docs/paper_errata.md` writes this page; a test keeps it current.
The columns are

- printed: the value in the paper,
- printed A: the plant (11), linearised by the matrix $A$ that (58) prints; for the entries of $A$
  themselves, (12) evaluated with the parameters of Table 1,
- with (11): the plant (11) and its own Jacobian,
- exact: the exact kinematics and their Jacobian.
"""

_CLOSING = r"""
## Remarks that concern more than one number

- (6), (7) and (9) replace $d/r$ by $\cos\chi$ and $z/r$ by $\sin\chi$. This is true only when the
  path angle equals the elevation angle of the target. The three models therefore have three
  different steady turns.
- (29) is equivalent to $L \le 1 - |A_K|_P$ for every $\rho$, because $|A_K|_P^2 = 1 - \rho\sigma$;
  (41) approaches it as $\rho$ grows.
- (47) counts one stage too few. From (45) follows $\sum_{j=0}^{N-1} \eta\,\tau^j + \tau^N$, which
  is more than $c_2$ where $\eta + \tau > 1$.
- (53) has $|x_k|$ where (35) has $|x_N|$. So (41) does not suffice: the argument needs
  $b \le (\rho - 1)\,\sigma$, which is stricter by $\xi$, and then proves (54) with $\xi$ in the
  place of $c_3$.
- (57) prints $c_2/c_3$. The argument needs $c_2$ divided by a lower bound of $V_N$, which is
  $\xi |x|^2$ in the norm of $P_\rho$.
- A level in a row "where ... stops" is the lowest level at which a violating state is known.
  `uav_tracking stability` proves how far each condition holds.
"""

# Mathematics of the rows, which the terminal prints as it stands, for a page that renders it.
_FORMULAS = {
    "2 L |A_K|_P + L^2": r"2 L |A_K|_P + L^2",
    "2 L |A_K|_P": r"2 L |A_K|_P",
    "|A_K|_P": r"|A_K|_P",
    "xi + (rho - 1) sigma": r"\xi + (\rho - 1)\,\sigma",
    "|u_psi - u_ss| <= pi/4": r"|u_\psi - u_{ss}| \le \pi/4",
    "U = (pi/4, pi/4, 1)": r"U = (\pi/4, \pi/4, 1)",
    "a_2 = lambda_max(P)": r"a_2 = \lambda_{max}(P)",
    "gamma = 1 - a_3 / a_2": r"\gamma = 1 - a_3 / a_2",
    "gamma > 1": r"\gamma > 1",
    "1 - a_3": r"1 - a_3",
    "P_rho = rho P": r"P_\rho = \rho P",
    "P_rho": r"P_\rho",
    "|x|^2": r"|x|^2",
    "c_2/c_3": r"c_2/c_3",
    "u_psi": r"u_\psi",
    "varrho": r"\alpha",
    "sigma": r"\sigma",
    "xi": r"\xi",
    **{symbol: symbol for symbol in ("L^2", "V_f", "V_N", "x_o", "c_2", "c_3")},
}
_FORMULA = re.compile(
    "|".join(rf"(?<!\w){re.escape(formula)}(?!\w)" for formula in _FORMULAS) + r"|A\[(\d),(\d)\]"
)


def cells(row: Row) -> tuple[str, ...]:
    """One row as text: numbers with four significant digits, or a dash."""
    return tuple(
        each if isinstance(each, str) else "-" if each is None else f"{each:.4g}"
        for each in row.values()
    )


def numbers_table(rows: Sequence[Row]) -> Table:
    """The numbers as a table for the terminal; its rows count those of the verdicts."""
    counted = [(str(count), *cells(row)[:-1]) for count, row in enumerate(rows, start=1)]
    return Table(("", *HEADINGS[:-1]), counted, title="The paper, quantity by quantity")


def verdicts(rows: Sequence[Row]) -> list[str]:
    """The verdict on each row of the table, one line each: too long for a column."""
    return [f"{count:3d}  {row['verdict']}" for count, row in enumerate(rows, start=1)]


def _rendered(text: str) -> str:
    """The text with its mathematics as LaTeX."""

    def formula(match: re.Match[str]) -> str:
        known = _FORMULAS.get(match[0])
        return f"$A_{{{match[1]}{match[2]}}}$" if known is None else f"${known}$"

    return _FORMULA.sub(formula, text)


def as_markdown(rows: Sequence[Row]) -> str:
    """The page ``docs/paper_errata.md``."""
    rendered = [tuple(map(_rendered, cells(row))) for row in rows]
    table = Table(HEADINGS, rendered).as_markdown()
    return f"{_INTRODUCTION}\n{table}\n{_CLOSING}"
