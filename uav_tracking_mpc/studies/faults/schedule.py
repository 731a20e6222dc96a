"""Which faults come when: a function of the seed alone, so that a failing case can be run again."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass

from uav_tracking_mpc.studies.faults.fault_kinds import KILL, KINDS, STOP

KILLING_FAULTS = 12  # per minute of campaign: how many faults may kill; after them nobody is
TOGETHER = (0.55, 0.85)  # one fault alone up to here, two up to here, else three
LATEST = 1.5  # s of simulated time after the case begins by which its last fault has begun


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        kind: Name of its kind.
        offset: When it begins, after its case, in simulated time [s].
        duration: How long it lasts [s], in the time of its kind.
        seed: For what is random within it.
    """

    kind: str
    offset: float
    duration: float
    seed: int


@dataclass(frozen=True)
class Case:
    """Faults that come together, followed by the time to recover from them.

    Attributes:
        index: Its number in the schedule, from 0.
        faults: At least one; at most one of them strikes a process.
    """

    index: int
    faults: tuple[Fault, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of its faults."""
        return tuple(fault.kind for fault in self.faults)


def schedule(seed: int, minutes: float) -> Iterator[Case]:
    """Cases without end: every kind once, then every kind again in another order.

    Nodes are killed early in the campaign alone, so that what survives lives long enough for a
    leak to show.

    Args:
        seed: Of everything random.
        minutes: Length of the campaign, which decides how long nodes are killed.
    """
    rng = random.Random(seed)
    killing = math.ceil(KILLING_FAULTS * minutes)
    dealt = index = 0
    deck: list[str] = []
    while True:
        draw = rng.random()
        wanted = 1 + sum(draw > share for share in TOGETHER)
        kinds: list[str] = []
        while len(kinds) < wanted:
            if not deck:
                deck = _deck(rng, dealt == 0 or dealt < killing)
            fitting = [name for name in deck if _fits(name, kinds)]
            if not fitting:
                break
            kinds.append(fitting[0])
            deck.remove(fitting[0])
        dealt += len(kinds)
        yield Case(index, tuple(_fault(rng, name) for name in kinds))
        index += 1


def _deck(rng: random.Random, killing: bool) -> list[str]:
    kills = [name for name, kind in KINDS.items() if kind.action == KILL]
    deck = [name for name in KINDS if name not in kills]
    rng.shuffle(deck)
    if killing:
        for name in kills:
            deck.insert(rng.randrange(len(deck) // 3), name)
    return deck


def _fits(name: str, others: list[str]) -> bool:
    """One stroke at a process at a time: with two of them nobody could say which did it."""
    processes = (KILL, STOP)
    if name in others:
        return False
    return KINDS[name].action not in processes or not any(
        KINDS[other].action in processes for other in others
    )


def _fault(rng: random.Random, name: str) -> Fault:
    kind = KINDS[name]
    return Fault(
        name,
        offset=rng.uniform(0.0, LATEST),
        duration=rng.uniform(kind.shortest, kind.longest),
        seed=rng.randrange(2**31),
    )
