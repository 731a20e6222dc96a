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

"""Every fault by its label, and which come when.

The schedule is a function of the seed alone, so that a failing case can be run again.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.studies.faults.kinds import FAULT, Fault


def variants(reference: str) -> dict[str, Fault]:
    """Variants of one class of faults.

    Args:
        reference: Name of the class in its room, or ``path.py:Class``.

    Returns:
        A new object of each, by its label.

    Raises:
        ExtensionError: There is no such class.
    """
    found = {}
    for fault in FAULT.find(reference).variants():
        fault.reference = reference
        found[fault.label] = fault
    return found


def catalogue(references: Iterable[str] = ()) -> dict[str, Fault]:
    """Variants of all faults that are installed, and of others.

    Args:
        references: Others, as ``path.py:Class``.

    Returns:
        Faults by label, those of a family side by side.

    Raises:
        ExtensionError: There is no such class, or it has the label of another one.
    """
    faults: dict[str, Fault] = {}
    for reference in dict.fromkeys((*FAULT.names, *references)):
        for label, fault in variants(reference).items():
            if label in faults:
                raise ExtensionError(
                    f"fault {reference!r} has the label {label!r} of fault "
                    f"{faults[label].reference!r}"
                )
            faults[label] = fault
    return dict(sorted(faults.items(), key=lambda item: (item[1].family, item[0])))


RESTARTING_FAULTS = 12  # faults a minute; among so many first faults nodes are restarted
TOGETHER = (0.55, 0.85)  # -, probability of one fault alone, and of two at most
LATEST = 1.5  # s of simulated time after the case begins by which its last fault has begun


@dataclass(frozen=True)
class ScheduledFault:
    """One fault of a case.

    Attributes:
        label: Of the fault in the catalogue.
        offset: When it begins, after its case, in simulated time [s].
        duration: How long it lasts, in simulated or wall time as the fault has it [s].
        seed: For what is random within it.
    """

    label: str
    offset: float
    duration: float
    seed: int


@dataclass(frozen=True)
class Case:
    """Faults that come together, followed by the time to recover from them.

    Attributes:
        index: Its number in the schedule, from 0.
        faults: At least one; at most one of them has a victim.
    """

    index: int
    faults: tuple[ScheduledFault, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Labels of its faults."""
        return tuple(fault.label for fault in self.faults)


def schedule(
    faults: Mapping[str, Fault],
    seed: int,
    minutes: float = 0.0,
    first: Collection[str] = (),
    most: int = 3,
) -> Iterator[Case]:
    """Cases without end: every fault once, then every fault again in another order.

    Nodes are killed early in the campaign alone, so that what survives lives long enough for a
    leak to show.

    Args:
        faults: To choose from, by label.
        seed: Of everything random.
        minutes: Length of the campaign, which decides how long nodes are killed [min].
        first: Labels of faults that come before all others.
        most: Faults that come together at most.

    Yields:
        One case after the other.
    """
    rng = random.Random(seed)
    restarting = math.ceil(RESTARTING_FAULTS * minutes)
    dealt = 0
    deck: list[str] = []
    for index in itertools.count():
        draw = rng.random()
        wanted = min(1 + sum(draw > share for share in TOGETHER), most)
        chosen: list[Fault] = []
        while len(chosen) < wanted:
            if not deck:
                deck = _deck(faults, rng, dealt == 0 or dealt < restarting)
                if dealt == 0:
                    deck = [*first, *(label for label in deck if label not in first)]
            fitting = [label for label in deck if _fits(faults[label], chosen)]
            if not fitting:
                break
            chosen.append(faults[fitting[0]])
            deck.remove(fitting[0])
        dealt += len(chosen)
        scheduled = (
            ScheduledFault(
                fault.label,
                offset=rng.uniform(0.0, LATEST),
                duration=rng.uniform(*fault.duration),
                seed=rng.randrange(2**31),
            )
            for fault in chosen
        )
        yield Case(index, tuple(scheduled))


def _deck(faults: Mapping[str, Fault], rng: random.Random, restarting: bool) -> list[str]:
    restarts = [label for label, fault in faults.items() if fault.restarts]
    deck = [label for label in faults if label not in restarts]
    rng.shuffle(deck)
    if restarting:
        for label in restarts:
            deck.insert(rng.randrange(len(deck) // 3 + 1), label)
    return deck


def _fits(fault: Fault, others: list[Fault]) -> bool:
    return fault not in others and not (fault.victim and any(other.victim for other in others))
