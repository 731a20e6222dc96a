"""The table of the comparison: for the terminal, and for a page of the documentation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from uav_tracking_mpc.studies.comparison.flights import NMPC
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.comparison.results import Scenario

COLUMNS = (
    "range RMS [m]", "settled [s]", "altitude RMS [m]", "airspeed RMS [m/s]",
    "bank rate RMS [deg/s]", "violations",
)  # fmt: skip
BEGIN, END = "<!-- table comparison -->\n", "<!-- end -->"


def as_table(scenarios: Sequence[Scenario]) -> Table:
    """For the terminal."""
    table = Table(box=SIMPLE_HEAD, caption=caption(), caption_justify="left")
    table.add_column("scenario", no_wrap=True)
    table.add_column("law", no_wrap=True)
    for column in COLUMNS:
        table.add_column(escape(column.replace(" [", "\n[")), justify="right")
    table.add_column("target", justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for row in rows(scenarios):
        if row[0]:
            table.add_section()
        table.add_row(*row, style="bold" if row[1] == NMPC else "")
    return table


def as_markdown(scenarios: Sequence[Scenario]) -> str:
    """For a page."""
    titles = ["scenario", "law", *COLUMNS, "target", "verdict"]
    lines = ["| " + " | ".join(titles) + " |", "|---|---|" + "---:|" * 7 + "---|"]
    lines += ["| " + " | ".join(row) + " |" for row in rows(scenarios)]
    return "\n".join(lines)


def write_into(page: Path, table: str) -> None:
    """Put a Markdown table between the two marks of a page.

    Raises:
        ValueError: The page has no such place.
    """
    text = page.read_text(encoding="utf-8")
    before, found, rest = text.partition(BEGIN)
    _, closed, after = rest.partition(END)
    if not (found and closed):
        raise ValueError(f"{page} has no place {BEGIN.strip()!r} for the table")
    page.write_text(f"{before}{BEGIN}{table}\n{END}{after}", encoding="utf-8")


def rows(scenarios: Sequence[Scenario]) -> list[list[str]]:
    """Scenario (once), law, the numbers, target and verdict (where set) of every flight."""
    return [
        [
            scenario.name if index == 0 else "",
            law,
            *_numbers(flight),
            *(_verdict(scenario) if law == NMPC else ("", "")),
        ]
        for scenario in scenarios
        for index, (law, flight) in enumerate(scenario.measures.items())
    ]


def misses(scenarios: Sequence[Scenario]) -> list[str]:
    """What the predictive controller missed, one line each."""
    return [f"{scenario.name}: {words}" for scenario in scenarios for words in scenario.missed]


def caption() -> str:
    """What the columns mean."""
    return (
        "RMS over the last third of the flight; settled: from then on within 10 m of the range; "
        "violations: samples at which airspeed, path angle, bank, specific force, height or "
        "distance is beyond its limit by more than 1 %; target: range RMS and settling of nmpc."
    )


def _numbers(flight: Measures) -> list[str]:
    return [
        f"{flight.range_rms_m:.3f}",
        "never" if flight.settling_s is None else f"{flight.settling_s:.1f}",
        f"{flight.altitude_rms_m:.3f}",
        f"{flight.airspeed_rms_mps:.3f}",
        f"{flight.bank_rate_rms_dps:.2f}",
        str(flight.envelope_violations),
    ]


def _verdict(scenario: Scenario) -> tuple[str, str]:
    if scenario.target is None:
        return "", ""
    asked = f"{scenario.target.range_rms:g} m, {scenario.target.settling:g} s"
    return asked, "missed" if scenario.missed else "reached"
