"""The paper report for people: a table in the terminal, JSON, and a page of the documentation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from uav_tracking_mpc.studies.stability.paper_report import Row, paper_report

HEADINGS = ("quantity", "where", "as printed", "printed A", "with (11)", "exact", "verdict")
PAGE = "paper_errata.md"

_INTRODUCTION = """# What the paper prints, and what is true

This page is generated (`uav_tracking stability --errata docs/paper_errata.md`); a test keeps it
current. Numbers are recomputed three times: with the matrix A that (58) prints in the place of a
linearisation (the plant is (11)), with (11) and its own Jacobian, and with the exact kinematics.
For the entries of A, the column "printed A" holds (12) evaluated with the parameters of Table 1.
"""

_CLOSING = """
## Remarks that are not about one number

- (6), (7) and (9) replace d/r by cos(chi) and z/r by sin(chi): true only where the path angle
  equals the target's elevation angle. Hence three different steady turns.
- (29) is exactly L <= 1 - |A_K|_P whatever rho, because |A_K|_P^2 = 1 - rho sigma; (41) tends to it
  as rho grows.
- (57) prints c_2/c_3 where the argument needs c_2 over a lower bound of V_N (xi |x|^2 in P_rho).
- The levels in the rows "where ... stops" are the lowest at which a state is known that breaks the
  condition. `uav_tracking stability` proves how far each condition holds.
"""


def number(value: float | None) -> str:
    """Four significant digits, or a dash."""
    return "-" if value is None else f"{value:.4g}"


def cells(row: Row) -> tuple[str, ...]:
    """One row as text."""
    return (
        row.name,
        row.equation,
        number(row.printed),
        number(row.printed_A),
        number(row.model_11),
        number(row.exact),
        row.verdict,
    )


def as_table(rows: Sequence[Row]) -> Any:
    """The numbers as a table for the terminal (rich); its rows count those of the verdicts."""
    from rich.table import Table

    table = Table(title="The paper, quantity by quantity")
    for heading in ("", *HEADINGS[:-1]):
        table.add_column(heading, overflow="fold")
    for number, row in enumerate(rows, start=1):
        table.add_row(str(number), *cells(row)[:-1])
    return table


def verdicts(rows: Sequence[Row]) -> list[str]:
    """The verdict on each row of the table, one line each: too long for a column."""
    return [f"{number:3d}  {cells(row)[-1]}" for number, row in enumerate(rows, start=1)]


def as_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Rows as JSON values."""
    return [asdict(row) for row in rows]


def as_markdown(rows: Sequence[Row]) -> str:
    """The page ``docs/paper_errata.md``."""
    lines = [
        "| " + " | ".join(HEADINGS) + " |",
        "|" + "---|" * len(HEADINGS),
        # A bar inside a cell would end it.
        *("| " + " | ".join(c.replace("|", "\\|") for c in cells(row)) + " |" for row in rows),
    ]
    return _INTRODUCTION + "\n" + "\n".join(lines) + "\n" + _CLOSING


def write_page(path: Path) -> None:
    """Recompute the report and write the page."""
    path.write_text(as_markdown(paper_report()))
