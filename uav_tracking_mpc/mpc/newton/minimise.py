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

"""The entry of compiled code: one attempt, or one from every opening.

Openings are tried in the order of what they cost without any step. The best plan is kept, and an
attempt that will not end below it is given up.
"""

import math

from .attempt import (  # noqa: F401 (codes for the caller)
    CONVERGED,
    HOPELESS,
    INFEASIBLE,
    ITERATION_LIMIT,
    NO_START,
    REFUSED,
    STALLED,
    TIME_LIMIT,
    attempt,
    better,
    copy_multipliers,
    copy_plan,
)
from .numba_options import compiled, entry
from .openings import feedback_to_goal, open_all, prepare_cheapest
from .stage import NP, NX, N
from .warm_start import move_on
from .workspace import ASIDE, KEPT, record_at

# How it begins: from the kept plan moved on; from what the caller put into row SECOND and the
# gains; from every opening. Or only the gains of the feedback to the goal.
WARM, PREPARED, ALL_OPENINGS, FEEDBACK = range(4)

WORTHWHILE = 1e-5  # relative difference in cost for which an attempt is finished


@entry
def minimise(address, start, stages, tolerance, iteration_limit, deadline):
    """Minimise the problem of a workspace; the plan is left in row KEPT.

    Args:
        address: Of the workspace in memory; x_0, p, horizon and ends are set.
        start: One of the codes above.
        stages: WARM: elapsed time over T_s.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations of one attempt.
        deadline: On the monotonic clock, in [s].

    Returns:
        How it ended; ``outcome`` holds Newton iterations and the relative gradient, the plan's
        value its cost and violation.
    """
    w = record_at(address)
    if not data_finite(w):
        return REFUSED
    if start == FEEDBACK:
        feedback_to_goal(w)
        return CONVERGED
    if start == WARM:
        move_on(w, stages)
    elif start == ALL_OPENINGS:
        feedback_to_goal(w)
        open_all(w)
    best, iterations, gradient = NO_START, 0.0, math.nan
    while start != ALL_OPENINGS or prepare_cheapest(w):
        bound = math.inf
        if best == CONVERGED:
            bound = w.value[ASIDE, 1] - WORTHWHILE * abs(w.value[ASIDE, 1])
        # The only call: the compiler puts the whole attempt here, and would again at another.
        end = attempt(w, tolerance, iteration_limit, deadline, bound)
        if start != ALL_OPENINGS:
            return end
        iterations += w.outcome[0]
        if end != HOPELESS and ranks_first(w, end, best, tolerance):
            best, gradient = end, w.outcome[1]
            copy_plan(w, KEPT, ASIDE)
            copy_multipliers(w, KEPT, ASIDE)
        if end == TIME_LIMIT:
            break
    if best != NO_START:
        copy_plan(w, ASIDE, KEPT)
        copy_multipliers(w, ASIDE, KEPT)
    w.outcome[0] = iterations
    w.outcome[1] = gradient
    return best


@compiled
def ranks_first(w, end, best, tolerance):
    """Whether an attempt's plan is better than the best so far: converged, feasible, cheap.

    Args:
        w: Workspace, with the plans in rows KEPT and ASIDE.
        end: How the attempt ended.
        best: How that of the best plan did; NO_START before there is one.
        tolerance: Largest violation of a plan that counts as feasible.
    """
    if best == NO_START or (end == CONVERGED) != (best == CONVERGED):
        return best == NO_START or end == CONVERGED
    return better(w, KEPT, ASIDE, tolerance)


@compiled
def data_finite(w):
    """Whether x_0 and p of the workspace ``w`` are finite."""
    for r in range(NX):
        if not math.isfinite(w.x_0[r]):
            return False
    for i in range(N + 1):
        for r in range(NP):
            if not math.isfinite(w.p[i, r]):
                return False
    return True
