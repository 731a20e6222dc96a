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

"""The modes as a state machine: everything there can be to fly by, and every way through it."""

import itertools
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.fallback import (
    UNFINISHED,
    Available,
    FallbackMode,
    ModeSelector,
    PlanMemory,
    choose,
)
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.mpc.solver import FEASIBLE_VIOLATION, Solution, Status


def solution(status, violation=0.0, message="told so"):
    empty = np.zeros((0, 3))
    return Solution(status, message, 1.0, 1, 0.01, empty, empty, np.zeros(0), violation)


MODES = tuple(FallbackMode)
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
SITUATIONS = [
    Available(*values)
    for values in itertools.product(
        *[(False, True)] * 3, SOLUTIONS, *[(False, True)] * 2, ("", "something is wrong")
    )
]
situations = st.sampled_from(SITUATIONS)


def quality(answer):
    """How much an answer of the solver is worth."""
    if answer is None:
        return 0
    if answer.converged:
        return 2
    return 1 if answer.status in UNFINISHED and answer.violation <= FEASIBLE_VIOLATION else 0


def test_a_reason_is_given_for_every_mode_but_the_nominal_ones():
    for available in SITUATIONS:
        mode, reason = choose(available)
        assert (reason == "") == mode.nominal


def test_every_mode_is_reached_from_every_other():
    reached = {choose(available)[0]: available for available in SITUATIONS}
    assert set(reached) == set(MODES)
    for before, after in itertools.permutations(MODES, 2):
        selector = ModeSelector()
        selector.select(reached[before])
        change = selector.select(reached[after])
        assert selector.mode is after
        assert f"before {before.value}" in change


@given(situations, situations)
def test_more_to_fly_by_never_leads_to_a_worse_mode(one, other):
    """The modes are a total order, and the choice follows it."""

    def measures(available):
        truths = available.state, available.target, available.target_fresh, available.plan_left
        return (*truths, available.law, quality(available.solution))

    if all(a >= b for a, b in zip(measures(one), measures(other), strict=True)):
        assert MODES.index(choose(one)[0]) <= MODES.index(choose(other)[0])


@given(st.lists(situations, max_size=30))
def test_counts_and_changes_add_up(walk):
    selector = ModeSelector()
    before, changes, stood = selector.mode, 0, Counter()
    assert before is FallbackMode.SILENCE and selector.reason
    for available in walk:
        change = selector.select(available)
        mode, reason = choose(available)
        assert (selector.mode, selector.reason) == (mode, reason)
        assert bool(change) == (mode is not before)
        changes += bool(change)
        stood[mode] += 1
        before = mode
    assert selector.changes == changes
    assert sum(selector.counts.values()) == len(walk)
    assert selector.counts == {mode: stood[mode] for mode in MODES}


FAILED, LATE = solution(Status.FAILED, 0.0, ""), solution(Status.TIME_LIMIT)


@pytest.mark.parametrize(
    ("there_is", "mode", "reason"),
    [
        ({"state": False, "plan_left": True}, "silence", "vehicle state is lost"),
        ({"target": False, "target_fresh": False}, "wings level", "no target position"),
        ({"target_fresh": False, "plan_left": True}, "loiter law", "target position is lost"),
        ({}, "loiter law", "no solution"),
        ({"solution": FAILED, "plan_left": True}, "earlier plan", "failed"),
        (
            {"solution": solution(Status.TIME_LIMIT, 2e-2), "plan_left": True},
            "earlier plan",
            "told so",
        ),
        ({"solution": LATE, "plan_left": True}, "feasible plan, not optimal", "told so"),
        ({"plan_left": True, "trouble": "it broke"}, "earlier plan", "it broke"),
        ({"solution": solution(Status.CONVERGED)}, "optimal plan", ""),
        ({"law": True}, "guidance law", ""),
    ],
)
def test_what_is_flown_and_why(there_is, mode, reason):
    assert choose(Available(**there_is)) == (FallbackMode(mode), reason)


def test_changes_read_as_sentences():
    selector, optimal = ModeSelector(), Available(solution=solution(Status.CONVERGED))
    assert selector.select(optimal) == "now flying optimal plan, before silence"
    down = selector.select(Available(target_fresh=False))
    assert down == "now flying loiter law, before optimal plan: target position is lost"
    assert selector.select(optimal) == "now flying optimal plan, before loiter law"
    silent = selector.select(Available(state=False))
    assert silent == "no command is sent, before optimal plan: vehicle state is lost"


def test_only_plans_count_as_planned():
    planned = {FallbackMode.OPTIMAL, FallbackMode.FEASIBLE, FallbackMode.EARLIER_PLAN}
    assert {mode for mode in MODES if mode.planned} == planned


NOTHING = np.zeros((0, 3))
SOLUTION = Solution(Status.CONVERGED, "", 1.0, 1, 0.0, NOTHING, NOTHING, np.zeros(3), 0.0)
PLAN = Plan(np.arange(9.0).reshape(3, 3), 0.5, np.zeros(5), SOLUTION)


@pytest.fixture
def memory():
    memory = PlanMemory()
    memory.keep(PLAN, 10.0)
    return memory


@pytest.mark.parametrize(("time", "first"), [(10.0, 0), (10.49, 0), (10.5, 1), (11.49, 2)])
def test_the_segments_that_have_been_flown_are_left_out(memory, time, first):
    inputs, step = memory.remaining(time, 5.0)
    np.testing.assert_array_equal(inputs, PLAN.inputs[first:])
    assert step == PLAN.step


@pytest.mark.parametrize(("time", "age_max"), [(9.9, 5.0), (11.5, 5.0), (10.6, 0.5)])
def test_a_plan_of_the_future_or_flown_or_too_old_is_none(memory, time, age_max):
    assert memory.remaining(time, age_max) is None


def test_what_is_forgotten_is_gone(memory):
    memory.reset()
    assert memory.remaining(10.0, 5.0) is None
