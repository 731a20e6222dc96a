"""The paper report for people: tables for the terminal and a page of the documentation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.studies.stability.paper_report import Row, paper_report

HEADINGS = ("quantity", "where", "as printed", "printed A", "with (11)", "exact", "verdict")

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


def as_markdown(rows: Sequence[Row]) -> str:
    """The page ``docs/paper_errata.md``.

    Args:
        rows: Of the report.
    """
    table = Table(HEADINGS, [cells(row) for row in rows]).as_markdown()
    return f"{_INTRODUCTION}\n{table}\n{_CLOSING}"


def write_page(path: Path) -> None:
    """Recompute the report and write the page.

    Args:
        path: File of the page.
    """
    write_atomically(path, as_markdown(paper_report()).encode())
