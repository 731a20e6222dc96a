"""The ladder as a state machine: every footing there can be, and every way through them."""

import itertools
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.fallback import (
    FEASIBLE_VIOLATION,
    RUNGS,
    UNFINISHED,
    Change,
    Footing,
    Ladder,
    Rung,
    choose,
)
from uav_tracking_mpc.mpc.solution import Solution, Status


def solution(status, violation=0.0, message="told so"):
    empty = np.zeros((0, 3))
    return Solution(status, message, 1.0, 1, 0.01, empty, empty, np.zeros(0), violation)


VIOLATIONS = (0.0, FEASIBLE_VIOLATION, 1.0, np.inf, np.nan)
SOLUTIONS = [
    None,
    *(
        solution(status, violation, message)
        for status in Status
        for violation in VIOLATIONS
        for message in ("told so", "")
    ),
]
FOOTINGS = [
    Footing(*values)
    for values in itertools.product(
        *[(False, True)] * 3, SOLUTIONS, (False, True), ("", "something is wrong")
    )
]
footings = st.sampled_from(FOOTINGS)


def quality(answer):
    """How much an answer of the solver is worth."""
    if answer is None:
        return 0
    if answer.converged:
        return 2
    return 1 if answer.status in UNFINISHED and answer.violation <= FEASIBLE_VIOLATION else 0


def test_a_reason_is_given_for_every_rung_but_the_top():
    for footing in FOOTINGS:
        rung, reason = choose(footing)
        assert (reason == "") == (rung is Rung.OPTIMAL)


def test_every_rung_is_reached_from_every_other():
    reached = {choose(footing)[0]: footing for footing in FOOTINGS}
    assert set(reached) == set(RUNGS)
    for before, after in itertools.permutations(RUNGS, 2):
        ladder = Ladder()
        ladder.step(reached[before])
        change = ladder.step(reached[after])
        assert (change.before, change.after) == (before, after)


@given(footings, footings)
def test_more_to_stand_on_never_leads_lower(one, other):
    """The rungs are a total order, and the choice follows it."""

    def measures(footing):
        truths = footing.state, footing.target, footing.target_fresh, footing.plan_left
        return (*truths, quality(footing.solution))

    if all(a >= b for a, b in zip(measures(one), measures(other), strict=True)):
        assert RUNGS.index(choose(one)[0]) <= RUNGS.index(choose(other)[0])


@given(st.lists(footings, max_size=30))
def test_counts_and_changes_add_up(walk):
    ladder = Ladder()
    before, changes, stood = ladder.rung, 0, Counter()
    assert before is Rung.SILENCE and ladder.reason
    for footing in walk:
        change = ladder.step(footing)
        rung, reason = choose(footing)
        assert (ladder.rung, ladder.reason) == (rung, reason)
        assert change == (Change(before, rung, reason) if rung is not before else None)
        changes += change is not None
        stood[rung] += 1
        before = rung
    assert ladder.changes == changes
    assert sum(ladder.counts.values()) == len(walk)
    assert ladder.counts == {rung: stood[rung] for rung in RUNGS}


@pytest.mark.parametrize(
    ("footing", "rung", "reason"),
    [
        (Footing(False, True, True, None, True), Rung.SILENCE, "vehicle state is lost"),
        (Footing(True, False, False, None, True), Rung.HOLD, "no target position"),
        (Footing(True, True, False, None, True), Rung.LOITER, "target position is lost"),
        (Footing(True, True, True, None, False), Rung.LOITER, "no solution"),
        (
            Footing(True, True, True, solution(Status.FAILED, 0.0, ""), True),
            Rung.EARLIER_PLAN,
            "failed",
        ),
        (
            Footing(True, True, True, solution(Status.TIME_LIMIT, 2e-2), True),
            Rung.EARLIER_PLAN,
            "told so",
        ),
        (Footing(True, True, True, solution(Status.TIME_LIMIT), True), Rung.FEASIBLE, "told so"),
        (Footing(True, True, True, None, True, "it broke"), Rung.EARLIER_PLAN, "it broke"),
        (Footing(True, True, True, solution(Status.CONVERGED), False), Rung.OPTIMAL, ""),
    ],
)
def test_where_one_stands_and_why(footing, rung, reason):
    assert choose(footing) == (rung, reason)


def test_changes_read_as_sentences():
    down = Change(Rung.OPTIMAL, Rung.LOITER, "target position is lost")
    assert str(down) == "now flying loiter law, before optimal plan: target position is lost"
    up = Change(Rung.LOITER, Rung.OPTIMAL, "")
    assert str(up) == "now flying optimal plans, before loiter law"


def test_only_plans_count_as_planned():
    assert [rung.planned for rung in RUNGS] == [True, True, True, False, False, False]
