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

"""What came of every case, and in total: as keys and values, as words, as a figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from uav_tracking_mpc.report.figure_style import BLUE, GREEN, GREY, VERMILLION, drawing, png
from uav_tracking_mpc.studies.faults.invariants import Violation

COUNTS = {"faults": 6, "violations": 10, "loiters": 7}  # columns and their widths


@dataclass
class CaseFindings:
    """What came of one case.

    Attributes:
        index: Its number in the schedule.
        kinds: Labels of its faults.
        begin: Since the campaign began [s].
        end: Likewise [s].
        recovery: From the last fault's end to the orbit [s] of simulated time; None: never.
        loiters: Whether it did not come back because the autopilot flies a circle of its own.
        violations: Of each invariant how often, and the first in words.
    """

    index: int
    kinds: tuple[str, ...]
    begin: float
    end: float = 0.0
    recovery: float | None = None
    loiters: bool = False
    violations: dict[str, tuple[int, str]] = field(default_factory=dict)

    def add(self, violation: Violation) -> None:
        """Count a violation; of each invariant the first is kept in words.

        Args:
            violation: What was found.
        """
        count, detail = self.violations.get(violation.invariant, (0, violation.detail))
        self.violations[violation.invariant] = (count + 1, detail)

    @property
    def lost(self) -> bool:
        """Whether the aircraft neither came back nor was to."""
        return self.recovery is None and not self.loiters


@dataclass(frozen=True)
class Campaign:
    """What a campaign was and found.

    Attributes:
        config: Name of the configuration.
        seed: Of the schedule.
        cases: One after the other.
        families: Of every fault that may be injected, by label, in the order of tables.
        range_errors: (time since the beginning [s], r - r_d [m]).
        tolerance: Range error within which the aircraft counts as on its orbit [m].
        limit: Time allowed for a recovery [s].
        more: What else ``--json`` prints, by key.
    """

    config: str
    seed: int
    cases: list[CaseFindings]
    families: Mapping[str, str]
    range_errors: list[tuple[float, float]]
    tolerance: float
    limit: float
    more: Mapping[str, Any]

    def summary(self) -> dict[str, Any]:
        """Keys and values as ``--json`` prints them.

        ``violations`` counts pairs of case and invariant: a thousand messages that break one rule
        in one case are one violation. ``worst_recovery_s`` is None if the aircraft never came back
        in some case. Faults that came together share what came of their case.
        """
        found = {label: [c for c in self.cases if label in c.kinds] for label in self.families}
        return {
            "config": self.config,
            "seed": self.seed,
            "cases": len(self.cases),
            "faults": sum(map(len, found.values())),
            "kinds": sum(map(bool, found.values())),
            "violations": sum(len(case.violations) for case in self.cases),
            "worst_recovery_s": _worst(self.cases),
            **self.more,
            "per_kind": {
                label: {
                    "faults": len(cases),
                    "violations": sum(len(case.violations) for case in cases),
                    "worst_recovery_s": _worst(cases),
                    **(
                        {"loiters": sum(c.loiters for c in cases)}
                        if "outcomes" in self.more
                        else {}
                    ),
                }
                for label, cases in found.items()
                if cases
            },
            "failing_cases": [
                {
                    "case": case.index,
                    "kinds": list(case.kinds),
                    "recovery_s": case.recovery,
                    "violations": {
                        name: {"count": count, "first": detail}
                        for name, (count, detail) in case.violations.items()
                    },
                }
                for case in self.cases
                if case.violations
            ],
        }


def _worst(cases: list[CaseFindings]) -> float | None:
    """The longest recovery [s], 0 where none was to be; None without cases, or if one is lost."""
    if not cases or any(case.lost for case in cases):
        return None
    return max(case.recovery or 0.0 for case in cases)


def table(summary: dict[str, Any]) -> str:
    """The summary for people.

    Args:
        summary: Of :meth:`Campaign.summary`.
    """
    rows = summary["per_kind"]
    counts = {k: w for k, w in COUNTS.items() if any(k in row for row in rows.values())}
    titles = "".join(f" {name:>{width}}" for name, width in counts.items())
    lines = [f"{'kind':28}{titles} {'worst recovery':>14}"]
    for name, row in rows.items():
        numbers = "".join(f" {row[key]:{width}d}" for key, width in counts.items())
        lines.append(f"{name:28}{numbers} {_time(row['worst_recovery_s']):>14}")
    words = [f"{summary['violations']} violations"]
    if "deaths" in summary:
        words.append(f"{summary['deaths']} deaths")
    words.append(f"worst recovery {_time(summary['worst_recovery_s'])}")
    if "rss_growth_percent" in summary:
        words.append(f"memory {summary['rss_growth_percent']:+.1f} % an hour")
    words += [f"{count} times {name}" for name, count in summary.get("outcomes", {}).items()]
    counted = "{faults} faults of {kinds} kinds in {cases} cases".format_map(summary)
    lines.append(f"{counted}: {', '.join(words)}")
    if "frames" in summary:
        lines.append(
            "{bad} bad frames: {taken} taken for messages, {good_lost} good ones lost; "
            "{bad_us:.1f} us each, a good one {good_us:.1f} us".format_map(summary["frames"])
        )
    for case in summary["failing_cases"]:
        for name, found in case["violations"].items():
            kinds = ", ".join(case["kinds"])
            told = f"{found['count']} times: {found['first']}"
            lines.append(f"case {case['case']} ({kinds}): {name}, {told}")
    return "\n".join(lines)


def _time(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.1f} s"


def timeline(campaign: Campaign) -> bytes:
    """The figure as PNG: how far from the orbit, what was injected, what came of it.

    Args:
        campaign: What to draw.
    """
    tolerance, limit = campaign.tolerance, campaign.limit
    families = list(dict.fromkeys(campaign.families.values()))
    with drawing(9.0, 6.5) as figure:
        upper, middle, lower = figure.subplots(
            3, 1, sharex=True, gridspec_kw={"height_ratios": (2, 2.4, 1.6)}
        )
        times = [time / 60.0 for time, _ in campaign.range_errors]
        upper.plot(times, [error for _, error in campaign.range_errors], color=BLUE, linewidth=0.8)
        upper.axhspan(-tolerance, tolerance, color=GREEN, alpha=0.15, linewidth=0)
        upper.set_ylabel("r - r_d [m]")
        upper.set_title(
            f"{campaign.config}, seed {campaign.seed}: true range error; "
            f"the band is {tolerance:g} m wide either way"
        )
        for case in campaign.cases:
            color = VERMILLION if case.violations else GREY
            width = max(case.end - case.begin, 0.2) / 60.0
            for kind in case.kinds:
                row = families.index(campaign.families[kind])
                middle.broken_barh([(case.begin / 60.0, width)], (row - 0.4, 0.8), color=color)
            height = limit if case.recovery is None else case.recovery
            lower.plot(case.begin / 60.0, height, "o", markersize=3, color=color)
        middle.set_yticks(range(len(families)), [name.replace("_", " ") for name in families])
        middle.invert_yaxis()
        middle.set_title("cases by what they strike; with violations in red")
        lower.axhline(limit, color=VERMILLION, linewidth=0.8, linestyle="--")
        lower.set_ylim(bottom=0.0)
        lower.set_ylabel("recovery [s]")
        lower.set_title(f"simulated time from the last fault to the orbit; allowed {limit:g} s")
        lower.set_xlabel("time [min]")
        figure.tight_layout()
        return png(figure)
