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

"""What came of every case, and in total."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from uav_tracking_mpc.studies.faults.invariants import Violation


@dataclass
class CaseFindings:
    """What came of one case.

    Attributes:
        index: Its number in the schedule.
        kinds: Labels of its faults.
        begin: Since the campaign began, wall time [s].
        end: Likewise [s].
        recovery: From the last fault's end to the orbit [s] of simulated time; None: never.
        violations: Of each invariant how often, and the first in words.
    """

    index: int
    kinds: tuple[str, ...]
    begin: float
    end: float = 0.0
    recovery: float | None = None
    violations: dict[str, tuple[int, str]] = field(default_factory=dict)

    def add(self, violation: Violation) -> None:
        """Count a violation; of each invariant the first is kept in words.

        Args:
            violation: What was found.
        """
        count, detail = self.violations.get(violation.invariant, (0, violation.detail))
        self.violations[violation.invariant] = (count + 1, detail)


@dataclass(frozen=True)
class Campaign:
    """What a campaign was and found.

    Attributes:
        config: Name of the configuration.
        seed: Of the schedule.
        minutes: Length asked for [min].
        speed: Simulated over wall time [-].
        interrupted: Whether the user ended it before its time; the case under way does not count.
        cases: One after the other.
        families: Of every fault that may be injected, by label, in the order of tables.
        deaths: Processes lost that nobody killed.
        growth: Memory of each process [%/h]; None where it was watched too briefly.
        range_errors: (wall time since the beginning [s], r - r_d [m]).
        storms: Parameters asked for, answered, accepted.
    """

    config: str
    seed: int
    minutes: float
    speed: float
    interrupted: bool
    cases: list[CaseFindings]
    families: Mapping[str, str]
    deaths: int
    growth: dict[str, float | None]
    range_errors: list[tuple[float, float]]
    storms: dict[str, int]

    def summary(self) -> dict[str, Any]:
        """Keys and values as ``--json`` prints them.

        ``violations`` counts pairs of case and invariant: a thousand messages that break one rule
        in one case are one violation. ``worst_recovery_s`` is None if the aircraft never came back
        in some case.
        """
        recoveries = [case.recovery for case in self.cases]
        known = [recovery for recovery in recoveries if recovery is not None]
        worst = max(known) if known and len(known) == len(recoveries) else None
        growths = [value for value in self.growth.values() if value is not None]
        return {
            "config": self.config,
            "seed": self.seed,
            "minutes": self.minutes,
            "speed": self.speed,
            "interrupted": self.interrupted,
            "cases": len(self.cases),
            "faults": sum(len(case.kinds) for case in self.cases),
            "kinds": len({kind for case in self.cases for kind in case.kinds}),
            "violations": sum(len(case.violations) for case in self.cases),
            "deaths": self.deaths,
            "worst_recovery_s": worst,
            "rss_growth_percent": max(growths, default=0.0),
            "rss_growth_percent_by_node": self.growth,
            "parameters": self.storms,
            "per_kind": per_kind(self.cases, self.families),
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


def per_kind(cases: Iterable[CaseFindings], order: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Of each fault that was injected: how often, violations and worst recovery of its cases.

    Faults that came together share what came of them.

    Args:
        cases: What came of every case.
        order: Labels of all faults.

    Returns:
        ``faults``, ``violations`` and ``worst_recovery_s`` [s] by label, in that order.
    """
    found: dict[str, dict[str, Any]] = {}
    for case in cases:
        for kind in case.kinds:
            row = found.setdefault(kind, {"faults": 0, "violations": 0, "worst_recovery_s": 0.0})
            row["faults"] += 1
            row["violations"] += len(case.violations)
            worst = row["worst_recovery_s"]
            never = worst is None or case.recovery is None
            row["worst_recovery_s"] = None if never else max(worst, case.recovery)
    return {label: found[label] for label in order if label in found}


def table(summary: dict[str, Any]) -> str:
    """The summary for people.

    Args:
        summary: Of :meth:`Campaign.summary`.
    """
    lines = [f"{'kind':28} {'faults':>6} {'violations':>10} {'worst recovery':>14}"]
    for name, row in summary["per_kind"].items():
        worst = _time(row["worst_recovery_s"])
        lines.append(f"{name:28} {row['faults']:6d} {row['violations']:10d} {worst:>14}")
    lines.append(
        f"{summary['faults']} faults of {summary['kinds']} kinds in {summary['cases']} cases: "
        f"{summary['violations']} violations, {summary['deaths']} deaths, worst recovery "
        f"{_time(summary['worst_recovery_s'])}, memory "
        f"{summary['rss_growth_percent']:+.1f} % an hour"
    )
    for case in summary["failing_cases"]:
        for name, found in case["violations"].items():
            lines.append(
                f"case {case['case']} ({', '.join(case['kinds'])}): {name}, "
                f"{found['count']} times: {found['first']}"
            )
    return "\n".join(lines)


def _time(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.1f} s"
