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

"""Cases one after the other: inject, watch, wait for the recovery; what came of it, as a study."""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

from matplotlib.figure import Figure
from rich.console import Console

from uav_tracking_mpc.report.figure_style import BLUE, GREEN, GREY, VERMILLION, drawing
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.invariants import RECOVERY_LIMIT, Recovery, Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.schedule import Case
from uav_tracking_mpc.studies.study import Study

STALL_LIMIT = 20.0  # s of wall time in which simulated time must move on
SAMPLE_PERIOD = 1.0  # s between errors that are kept for the figure


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
        """Count a violation; of each invariant the first is kept in words."""
        count, detail = self.violations.get(violation.invariant, (0, violation.detail))
        self.violations[violation.invariant] = (count + 1, detail)

    @property
    def lost(self) -> bool:
        """Whether the aircraft neither came back nor was to."""
        return self.recovery is None and not self.loiters


class Injection:
    """A fault that has begun; it is copied.

    Args:
        duration: How long it lasts, in simulated or wall time as the fault has it [s].
        seed: Of everything random in it.
        flight: What it acts on.

    Attributes:
        settled: Whether it has ended and its end has taken effect.
    """

    def __init__(self, fault: Fault, duration: float, seed: int, flight: Any) -> None:
        self._fault, self._flight = copy.copy(fault), flight
        seconds = duration if fault.wall_time else duration / flight.speed
        self._end = self._flight.now() + seconds
        self._ended = self.settled = False
        self._fault.begin(flight, seconds, seed)

    def step(self) -> list[Violation]:
        """Go on with the fault, or end it when its time is over.

        Returns:
            What must hold with this fault and does not.
        """
        if self._flight.now() < self._end:
            self._fault.during(self._flight)
        else:
            self.end()
            self.settled = self._fault.settled(self._flight)
        return self._fault.violations(self._flight)

    def end(self) -> None:
        """End the fault, once."""
        if not self._ended:
            self._ended = True
            self._fault.end(self._flight)


class FaultCampaign(ABC):
    """Cases on one flight, which the faults act on.

    Args:
        configuration: What to fly.
        faults: That the cases name, by label.
        console: Where progress goes.

    Attributes:
        tolerance: Error of range and altitude on the orbit [m].
        speed: Simulated over the time of :meth:`now` [-].
        recovery: Told of every state.
        violations: Found in the present case.
        found: What came of each case.
        range_errors: (:meth:`now`, r - r_d [m]), now and then.
    """

    tolerance: ClassVar[float]
    speed = 1.0

    def __init__(
        self, configuration: Configuration, faults: Mapping[str, Fault], console: Console
    ) -> None:
        self.configuration, self._faults, self._console = configuration, faults, console
        self.recovery = Recovery(self.tolerance)
        self.violations: list[Violation] = []
        self.found: list[CaseFindings] = []
        self.range_errors: list[tuple[float, float]] = []

    @abstractmethod
    def now(self) -> float:
        """Time since the campaign began [s]."""

    @abstractmethod
    def watch(self, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """Fly on and judge what happens; yield now and then whether simulated time stands still.

        Args:
            injections: Under which simulated time may stand still.
        """

    def prepare(self) -> None:  # noqa: B027 - not every campaign needs it
        """Do what comes before a case."""

    def excused(self, case: Case) -> bool:
        """Whether the aircraft is right not to come back by itself from a case."""
        return False

    def begin_anew(self) -> bool:
        """Begin another flight after an exception; whether there can be one."""
        return False

    def blame(self, invariant: str, detail: str) -> None:
        """Note that something must not be.

        Args:
            invariant: What is violated, in a word or two.
            detail: With numbers.
        """
        self.violations.append(Violation(invariant, detail))

    def sample(self) -> None:
        """Keep the range error, now and then."""
        if not self.range_errors or self.now() - self.range_errors[-1][0] > SAMPLE_PERIOD:
            self.range_errors.append((self.now(), self.recovery.range_error))

    def fly_cases(self, cases: Iterable[Case], end: float = math.inf) -> bool:
        """Fly cases until there are no more, the time is over or the user interrupts.

        Args:
            cases: In this order.
            end: When no case begins any more, by :meth:`now` [s].

        Returns:
            Whether the user interrupted; the case under way does not count.

        Raises:
            KeyboardInterrupt: Before the first case was flown.
        """
        try:
            for case in cases:
                if self.now() > end:
                    break
                self.found.append(self.fly_case(case))
                self._report()
        except KeyboardInterrupt:
            if not self.found:
                raise
            return True
        return False

    def fly_case(self, case: Case) -> CaseFindings:
        """What comes of one case."""
        findings = CaseFindings(case.index, case.kinds, self.now())
        try:
            self.prepare()
            with ExitStack() as ends:
                self._inject(case, ends)
                self.recovery.begin()
                findings.recovery = self._recovered()
            findings.loiters = findings.recovery is None and self.excused(case)
            if findings.lost:
                words = f"r - r_d is {self.recovery.range_error:.1f} m after {RECOVERY_LIMIT:g} s"
                if not self.recovery.late():
                    words = f"simulated time stood still for {STALL_LIMIT:g} s"
                self.blame("recovery", words)
        except Exception as error:
            if not self.begin_anew():
                raise
            self.blame("exception", f"{type(error).__name__}: {error}")
        findings.end = self.now()
        for violation in self.violations:
            findings.add(violation)
        self.violations.clear()
        return findings

    def study(self, seed: int, **more: Any) -> Study:
        """What was found; it is good if nothing was violated and no process died.

        Args:
            seed: Of the cases.
            more: What else ``--json`` prints.
        """
        families = {label: fault.family for label, fault in self._faults.items()}
        config = self.configuration.name
        content = {"config": config, "seed": seed, **summary(self.found, families, **more)}
        title = f"{config}, seed {seed}"
        draw = partial(timeline, title, self.found, families, self.range_errors, self.tolerance)
        return Study(
            "torture",
            content,
            in_words(content),
            figures={"timeline": draw},
            good=not (content["violations"] or content.get("deaths")),
            left="what came later was not flown" if content["interrupted"] else "",
        )

    def _inject(self, case: Case, ends: ExitStack) -> None:
        """Begin each fault at its time; return when all have settled, or time stands still."""
        begin, injections = self.recovery.flown, list[Injection]()
        pending = sorted(case.faults, key=lambda fault: fault.offset)
        for stalled in self.watch(injections):
            while pending and self.recovery.flown - begin >= pending[0].offset:
                scheduled = pending.pop(0)
                fault = self._faults[scheduled.label]
                injections.append(Injection(fault, scheduled.duration, scheduled.seed, self))
                ends.callback(injections[-1].end)
            running = [injection for injection in injections if not injection.settled]
            for injection in running:
                self.violations += injection.step()
            if not running and (stalled or not pending):
                return

    def _recovered(self) -> float | None:
        """Time in [s] until the aircraft is back on its orbit; None if it will not be."""
        for stalled in self.watch():
            recovered = self.recovery.done()
            if recovered is not None and recovered <= RECOVERY_LIMIT:
                return recovered
            if stalled or self.recovery.late():
                break
        return None

    def _report(self) -> None:
        case = self.found[-1]
        faults = sum(len(other.kinds) for other in self.found)
        line = (
            f"{case.end:6.1f} s  case {case.index:4d}  {faults:4d} faults  recovery "
            f"{_time(case.recovery)}  {', '.join(case.kinds)}"
        )
        if case.violations:
            line += f"  VIOLATED: {', '.join(case.violations)}"
        self._console.print(line, highlight=False, markup=False, soft_wrap=True)


def summary(
    cases: Sequence[CaseFindings], families: Mapping[str, str], **more: Any
) -> dict[str, Any]:
    """Keys and values as ``--json`` prints them.

    ``violations`` counts pairs of case and invariant: a thousand messages that break one rule in
    one case are one violation. ``worst_recovery_s`` is None if the aircraft never came back in some
    case. Faults that came together share what came of their case.

    Args:
        cases: One after the other.
        families: Of every fault that may be injected, by label, in the order of tables.
        more: What else is printed.
    """
    found = {label: [c for c in cases if label in c.kinds] for label in families}
    kinds = {label: _counted(those) for label, those in found.items() if those}
    total = _counted(cases)
    return {
        "cases": len(cases),
        "faults": sum(map(len, found.values())),
        "kinds": len(kinds),
        "violations": total["violations"],
        "worst_recovery_s": total["worst_recovery_s"],
        "outcomes": {
            "orbit": sum(case.recovery is not None for case in cases),
            "loiter": total["loiters"],
            "lost": sum(case.lost for case in cases),
        },
        **more,
        "per_kind": kinds,
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
            for case in cases
            if case.violations
        ],
    }


def _counted(cases: Sequence[CaseFindings]) -> dict[str, Any]:
    """Cases, violations and longest recovery [s], 0 where none was to be; None if one is lost."""
    known = bool(cases) and not any(case.lost for case in cases)
    return {
        "faults": len(cases),
        "violations": sum(len(case.violations) for case in cases),
        "loiters": sum(case.loiters for case in cases),
        "worst_recovery_s": max(case.recovery or 0.0 for case in cases) if known else None,
    }


def in_words(content: dict[str, Any]) -> list[str | Table]:
    """A :func:`summary` for people."""
    counts = ("faults", "violations", "loiters")
    cells = [
        [kind, *(str(row[name]) for name in counts), _time(row["worst_recovery_s"])]
        for kind, row in content["per_kind"].items()
    ]
    headings = ("kind", *counts, "worst recovery")
    words = [f"{content['violations']} violations"]
    if "deaths" in content:
        words.append(f"{content['deaths']} deaths")
    words.append(f"worst recovery {_time(content['worst_recovery_s'])}")
    if "rss_growth_percent" in content:
        words.append(f"memory {content['rss_growth_percent']:+.1f} % an hour")
    words += [f"{count} times {name}" for name, count in content["outcomes"].items()]
    counted = "{faults} faults of {kinds} kinds in {cases} cases".format_map(content)
    lines = [f"{counted}: {', '.join(words)}"]
    if "frames" in content:
        lines.append(
            "{bad} bad frames: {taken} taken for messages, {good_lost} good ones lost; "
            "{bad_us:.1f} us each, a good one {good_us:.1f} us".format_map(content["frames"])
        )
    lines += [
        f"case {case['case']} ({', '.join(case['kinds'])}): {name}, {found['count']} times: "
        f"{found['first']}"
        for case in content["failing_cases"]
        for name, found in case["violations"].items()
    ]
    return [Table(headings, cells, numeric=headings[1:]), *lines]


def _time(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.1f} s"


def timeline(
    title: str,
    cases: Sequence[CaseFindings],
    families: Mapping[str, str],
    range_errors: Sequence[tuple[float, float]],
    tolerance: float,
) -> Figure:
    """How far from the orbit, what was injected, what came of it.

    Args:
        title: Of the campaign.
        cases: One after the other.
        families: Of every fault by label, in their order.
        range_errors: (time since the beginning [s], r - r_d [m]).
        tolerance: Range error within which the aircraft counts as on its orbit [m].
    """
    names = list(dict.fromkeys(families.values()))
    with drawing(9.0, 6.5) as figure:
        upper, middle, lower = figure.subplots(
            3, 1, sharex=True, gridspec_kw={"height_ratios": (2, 2.4, 1.6)}
        )
        times = [time / 60.0 for time, _ in range_errors]
        upper.plot(times, [error for _, error in range_errors], color=BLUE, linewidth=0.8)
        upper.axhspan(-tolerance, tolerance, color=GREEN, alpha=0.15, linewidth=0)
        upper.set(
            ylabel="r - r_d [m]",
            title=f"{title}: true range error; the band is {tolerance:g} m wide either way",
        )
        for case in cases:
            color = VERMILLION if case.violations else GREY
            width = max(case.end - case.begin, 0.2) / 60.0
            for kind in case.kinds:
                row = names.index(families[kind])
                middle.broken_barh([(case.begin / 60.0, width)], (row - 0.4, 0.8), color=color)
            height = RECOVERY_LIMIT if case.recovery is None else case.recovery
            lower.plot(case.begin / 60.0, height, "o", markersize=3, color=color)
        middle.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        middle.invert_yaxis()
        middle.set_title("cases by what they strike; with violations in red")
        lower.axhline(RECOVERY_LIMIT, color=VERMILLION, linewidth=0.8, linestyle="--")
        lower.set(
            ylabel="recovery [s]",
            xlabel="time [min]",
            ylim=(0.0, None),
            title=f"simulated time from the last fault to the orbit; allowed {RECOVERY_LIMIT:g} s",
        )
        figure.tight_layout()
    return figure
