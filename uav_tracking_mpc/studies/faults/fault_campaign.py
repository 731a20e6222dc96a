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

"""Cases one after the other: inject, watch, wait for the recovery, write down; whatever flies."""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

from rich.console import Console

from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings
from uav_tracking_mpc.studies.faults.invariants import Recovery, Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.schedule import Case

HOLD = 2.0  # s of simulated time that the orbit must be held
RECOVERY_LIMIT = 30.0  # s of simulated time
STALL_LIMIT = 20.0  # s of wall time in which simulated time must move on


class Injection:
    """A fault that has begun.

    Args:
        fault: Which; it is copied.
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
    """Cases on one flight.

    Args:
        configuration: What to fly.
        faults: That the cases name, by label.
        console: Where progress goes.

    Attributes:
        tolerance: Error of range and altitude on the orbit [m].
        flight: What the faults act on.
        recovery: Told of every state.
        found: What came of each case.
        range_errors: (:meth:`now`, r - r_d [m]), now and then.
    """

    tolerance: ClassVar[float]
    flight: Any

    def __init__(
        self, configuration: Configuration, faults: Mapping[str, Fault], console: Console
    ) -> None:
        self.configuration, self._faults, self._console = configuration, faults, console
        self.recovery = Recovery(self.tolerance, HOLD, RECOVERY_LIMIT)
        self.found: list[CaseFindings] = []
        self.range_errors: list[tuple[float, float]] = []

    @abstractmethod
    def now(self) -> float:
        """Time since the campaign began [s]."""

    @property
    @abstractmethod
    def flown(self) -> float:
        """Simulated time that was flown [s]."""

    @property
    @abstractmethod
    def range_error(self) -> float:
        """The latest r - r_d [m]."""

    @abstractmethod
    def watch(self, findings: CaseFindings, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """Fly on and judge what happens; yield now and then whether simulated time stands still.

        Args:
            findings: Of the present case.
            injections: Under which simulated time may stand still.
        """

    def excused(self, findings: CaseFindings) -> bool:
        """Whether the aircraft is right not to come back by itself.

        Args:
            findings: Of the case that it does not recover from.
        """
        return False

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
        """What comes of one case.

        Args:
            case: To fly.
        """
        findings = CaseFindings(case.index, case.kinds, self.now())
        injections: list[Injection] = []
        try:
            self._inject(case, injections, findings)
            self.recovery.begin(self.flown)
            self._recover(findings)
        finally:
            for injection in injections:
                injection.end()
        findings.end = self.now()
        return findings

    def campaign(self, seed: int, **more: Any) -> Campaign:
        """What was found.

        Args:
            seed: Of the cases.
            more: What else ``--json`` prints.
        """
        families = {label: fault.family for label, fault in self._faults.items()}
        return Campaign(
            self.configuration.name, seed, self.found, families, self.range_errors,
            self.tolerance, RECOVERY_LIMIT, more,
        )  # fmt: skip

    def _inject(self, case: Case, injections: list[Injection], findings: CaseFindings) -> None:
        """Begin each fault at its time; return when all have settled, or time stands still."""
        begin = self.flown
        pending = sorted(case.faults, key=lambda fault: fault.offset)
        for stalled in self.watch(findings, injections):
            while pending and self.flown - begin >= pending[0].offset:
                scheduled = pending.pop(0)
                fault = self._faults[scheduled.label]
                injections.append(Injection(fault, scheduled.duration, scheduled.seed, self.flight))
            running = [injection for injection in injections if not injection.settled]
            for injection in running:
                for violation in injection.step():
                    findings.add(violation)
            if not running and (stalled or not pending):
                return

    def _recover(self, findings: CaseFindings) -> None:
        """Wait until the aircraft is back on its orbit, or will not be."""
        for stalled in self.watch(findings):
            findings.recovery = self.recovery.done(self.flown)
            if findings.recovery is not None and findings.recovery <= RECOVERY_LIMIT:
                return
            if stalled or self.recovery.late(self.flown):
                words = f"r - r_d is {self.range_error:.1f} m after {RECOVERY_LIMIT:g} s"
                if stalled:
                    words = f"simulated time stood still for {STALL_LIMIT:g} s"
                findings.recovery, findings.loiters = None, self.excused(findings)
                if not findings.loiters:
                    findings.add(Violation("recovery", words))
                return

    def _report(self) -> None:
        case = self.found[-1]
        recovery = "never" if case.recovery is None else f"{case.recovery:.1f} s"
        faults = sum(len(other.kinds) for other in self.found)
        line = f"{case.end:6.1f} s  case {case.index:4d}  {faults:4d} faults  recovery {recovery}"
        line += "  " + ", ".join(case.kinds)
        if case.violations:
            line += "  VIOLATED: " + ", ".join(case.violations)
        self._console.print(line, highlight=False, markup=False, soft_wrap=True)
