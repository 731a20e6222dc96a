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

"""Faults one after the other on one flight over a link, and what came of each."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from uav_tracking_mpc.autopilot.stepped_autopilot import SteppedAutopilot
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.recovery import Recovery
from uav_tracking_mpc.studies.link_faults.bad_frames import read_bad_frames
from uav_tracking_mpc.studies.link_faults.link_fault_kinds import KINDS
from uav_tracking_mpc.studies.link_faults.link_flight import LinkFlight

TOLERANCE, HELD, RECOVERY_LIMIT = 1.0, 2.0, 30.0  # m, s, s
SETTLING_LIMIT = 90.0  # s to the orbit, from wherever the autopilot was left
ORBIT, LOITER, LOST = "orbit", "loiter", "lost"
OURS = ("GUIDED", "OFFBOARD")  # modes of external commands
BAD_FRAMES = 100_000
LOITERS = ("LOITER", "RTL", "HOLD", "RETURN", *OURS)  # in which the autopilot circles by itself


@dataclass
class LinkCase:
    """What came of one fault.

    Attributes:
        kind: Of the fault.
        duration: Of the fault in [s].
        outcome: ``orbit``: back on it by itself; ``loiter``: the autopilot flies a circle of its
            own and waits to be engaged; ``lost``: neither.
        recovery: From its end to the orbit in [s]; None where it did not come back by itself.
        violations: Of each rule how often it was broken, and how for the first time.
    """

    kind: str
    duration: float = 0.0
    outcome: str = LOST
    recovery: float | None = None
    violations: dict[str, tuple[int, str]] = field(default_factory=dict)


def fly_cases(
    dialect: str,
    configuration: Configuration,
    count: int,
    seed: int,
    kinds: Sequence[str] = tuple(KINDS),
    progress: Callable[[int, str], None] = lambda done, kind: None,
) -> list[LinkCase]:
    """Fly under faults.

    Args:
        dialect: Name of the link and of the simulated autopilot.
        configuration: What is flown.
        count: How many faults.
        seed: Of everything random.
        kinds: Of the faults; each comes once before any comes again.
        progress: Called before each fault with how many are over and its kind, and at the end.

    Raises:
        LinkError: The autopilot refuses to be flown.
    """
    random_, cases = random.Random(seed), list[LinkCase]()
    flight = LinkFlight(dialect, configuration)
    order: list[str] = []
    for index in range(count):
        order = order or random_.sample(list(kinds), len(kinds))
        case = LinkCase(order.pop())
        progress(index, case.kind)
        cases.append(case)
        struck = flight
        try:
            _engage(flight)
            case.duration = KINDS[case.kind](flight, random_)
            _recover(flight, case)
            if case.outcome == LOST:
                flight.sent.blame("recovery", "neither on its orbit nor in a loiter")
        except Exception as error:  # nothing may end a flight
            struck.sent.blame("exception", f"{type(error).__name__}: {error}")
            flight = LinkFlight(dialect, configuration)
        case.violations = struck.sent.take()
    progress(count, "")
    return cases


def _engage(flight: LinkFlight) -> None:
    """Hand command over as a pilot does, and wait for the orbit."""
    recovery = Recovery(TOLERANCE, HELD, SETTLING_LIMIT)
    recovery.begin(flight.time)
    asked = -1.0
    if not flight.link.engaged:
        flight.autopilot.pilot_mode(flight.autopilot.core.loiter_mode)
    while recovery.done(flight.time) is None:
        flight.step()
        if not flight.link.engaged and flight.time - asked > 1.0:
            asked = flight.time
            flight.link.engage()
        recovery.state(flight.time, *flight.errors, flight.link.engaged)
        if recovery.late(flight.time):
            raise RuntimeError(f"not on the orbit {SETTLING_LIMIT:g} s after it was engaged")


def _recover(flight: LinkFlight, case: LinkCase) -> None:
    recovery = Recovery(TOLERANCE, HELD, RECOVERY_LIMIT)
    recovery.begin(flight.time)
    while not recovery.late(flight.time):
        flight.step()
        recovery.state(flight.time, *flight.errors, flight.link.engaged)
        case.recovery = recovery.done(flight.time)
        if case.recovery is not None:
            case.outcome = ORBIT
            return
    by_itself = flight.autopilot.core.mode in LOITERS
    given_back = not flight.link.engaged or case.kind == "take_over"
    if given_back and (by_itself or case.kind == "take_over"):
        case.outcome = LOITER


def summary(
    dialect: str, configuration: Configuration, seed: int, cases: Sequence[LinkCase]
) -> dict[str, Any]:
    """Keys and values as ``--json`` prints them.

    Args:
        dialect: Of the autopilot.
        configuration: What was flown.
        seed: Of everything random.
        cases: What came of each.
    """
    recoveries = [case.recovery for case in cases if case.recovery is not None]
    found = {kind: [case for case in cases if case.kind == kind] for kind in KINDS}
    return {
        "config": configuration.name,
        "dialect": dialect,
        "seed": seed,
        "cases": len(cases),
        "faults": len(cases),
        "kinds": len({case.kind for case in cases}),
        "violations": sum(len(case.violations) for case in cases),
        "outcomes": {name: sum(c.outcome == name for c in cases) for name in (ORBIT, LOITER, LOST)},
        "worst_recovery_s": max(recoveries, default=0.0),
        "per_kind": {
            kind: {
                "faults": len(of_kind),
                "violations": sum(len(case.violations) for case in of_kind),
                "loiters": sum(case.outcome == LOITER for case in of_kind),
                "worst_recovery_s": max((case.recovery or 0.0 for case in of_kind), default=0.0),
            }
            for kind, of_kind in found.items()
            if of_kind
        },
        "failing_cases": [
            {
                "case": index,
                "kinds": [case.kind],
                "recovery_s": case.recovery,
                "violations": {
                    name: {"count": times, "first": words}
                    for name, (times, words) in case.violations.items()
                },
            }
            for index, case in enumerate(cases)
            if case.violations
        ],
    }


def bad_frames(dialect: str, configuration: Configuration, seed: int) -> dict[str, float]:
    """What the link's end of the wire makes of :data:`BAD_FRAMES`: see :func:`read_bad_frames`.

    Args:
        dialect: Of the autopilot.
        configuration: What is flown.
        seed: Of everything random.
    """
    connection = SteppedAutopilot(dialect, configuration).connection("", 191, "")
    return read_bad_frames(connection, BAD_FRAMES, seed)


def table(found: dict[str, Any]) -> str:
    """The summary for people.

    Args:
        found: Of :func:`summary`.
    """
    lines = [f"{'kind':16} {'faults':>6} {'violations':>10} {'loiters':>7} {'worst recovery':>14}"]
    for kind, row in found["per_kind"].items():
        lines.append(
            f"{kind:16} {row['faults']:6d} {row['violations']:10d} {row['loiters']:7d} "
            f"{row['worst_recovery_s']:12.1f} s"
        )
    outcomes = found["outcomes"]
    lines.append(
        f"{found['faults']} faults of {found['kinds']} kinds: {found['violations']} violations; "
        f"{outcomes[ORBIT]} times back on the orbit, after {found['worst_recovery_s']:.1f} s at "
        f"most, {outcomes[LOITER]} times in the autopilot's loiter, {outcomes[LOST]} lost"
    )
    if frames := found.get("frames"):
        lines.append(
            f"{frames['bad']} bad frames: {frames['taken']} taken for messages, "
            f"{frames['good_lost']} good ones lost; {frames['bad_us']:.1f} us each, a good one "
            f"{frames['good_us']:.1f} us"
        )
    for case in found["failing_cases"]:
        for rule, what in case["violations"].items():
            kind = case["kinds"][0]
            times, first = what["count"], what["first"]
            lines.append(f"case {case['case']} ({kind}): {rule}, {times} times: {first}")
    return "\n".join(lines)
