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

"""The paper report for people: tables for the terminal and a page of the documentation."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.studies.stability.paper_report import Row, paper_report

HEADINGS = ("quantity", "where", "as printed", "printed A", "with (11)", "exact", "verdict")

_INTRODUCTION = """# What the paper prints, and what is true

This page is generated (`uav_tracking stability --errata docs/paper_errata.md`); a test keeps it
current. Numbers are recomputed three times: with the matrix $A$ that (58) prints in the place of a
linearisation (the plant is (11)), with (11) and its own Jacobian, and with the exact kinematics.
For the entries of $A$, the column "printed A" holds (12) evaluated with the parameters of Table 1.
"""

_CLOSING = r"""
## Remarks that are not about one number

- (6), (7) and (9) replace $d/r$ by $\cos\chi$ and $z/r$ by $\sin\chi$: true only where the path
  angle equals the target's elevation angle. Hence three different steady turns.
- (29) is exactly $L \le 1 - |A_K|_P$ whatever $\rho$, because $|A_K|_P^2 = 1 - \rho\sigma$; (41)
  tends to it as $\rho$ grows.
- (57) prints $c_2/c_3$ where the argument needs $c_2$ over a lower bound of $V_N$, which is
  $\xi |x|^2$ in $P_\rho$.
- The levels in the rows "where ... stops" are the lowest at which a state is known that breaks the
  condition. `uav_tracking stability` proves how far each condition holds.
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


def number(value: float | None) -> str:
    """Four significant digits, or a dash.

    Args:
        value: What to print [-].
    """
    return "-" if value is None else f"{value:.4g}"


def cells(row: Row) -> tuple[str, ...]:
    """One row as text.

    Args:
        row: Of the report.
    """
    numbers = (row.printed, row.printed_A, row.model_11, row.exact)
    return (row.name, row.equation, *map(number, numbers), row.verdict)


def numbers_table(rows: Sequence[Row]) -> Table:
    """The numbers as a table for the terminal; its rows count those of the verdicts.

    Args:
        rows: Of the report.
    """
    counted = [(str(count), *cells(row)[:-1]) for count, row in enumerate(rows, start=1)]
    return Table(("", *HEADINGS[:-1]), counted, title="The paper, quantity by quantity")


def verdicts(rows: Sequence[Row]) -> list[str]:
    """The verdict on each row of the table, one line each: too long for a column.

    Args:
        rows: Of the report.
    """
    return [f"{count:3d}  {row.verdict}" for count, row in enumerate(rows, start=1)]


def _rendered(text: str) -> str:
    """The text with its mathematics as LaTeX."""

    def formula(match: re.Match[str]) -> str:
        known = _FORMULAS.get(match[0])
        return f"$A_{{{match[1]}{match[2]}}}$" if known is None else f"${known}$"

    return _FORMULA.sub(formula, text)


def as_markdown(rows: Sequence[Row]) -> str:
    """The page ``docs/paper_errata.md``.

    Args:
        rows: Of the report.
    """
    rendered = [tuple(map(_rendered, cells(row))) for row in rows]
    table = Table(HEADINGS, rendered).as_markdown()
    return f"{_INTRODUCTION}\n{table}\n{_CLOSING}"


def write_page(path: Path) -> None:
    """Recompute the report and write the page.

    Args:
        path: File of the page.
    """
    write_atomically(path, as_markdown(paper_report()).encode())
