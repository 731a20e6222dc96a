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

"""What is guaranteed of the problem with the artificial orbit, why, and what is not."""

from __future__ import annotations

PREMISE = "The aircraft flies as predicted; solves converge, to no worse than the plan continued."

GUARANTEED = (
    "Commands keep to turn rate (bank, yaw rate), path-angle rate and specific force at every "
    "stage: the inputs are shares of what these limits leave in the stage's state.",
    "Feasible once is feasible for ever, without drift: the plan ends on an orbit that the "
    "optimiser chose among those that can be flown all the way round, with that orbit's rates. Its "
    "steady inputs, held, stay on it: the rest of the plan and one more step of the orbit are a "
    "plan again.",
    "The optimal cost falls by at least the stage cost, without drift: that plan costs as much "
    "less, since on the orbit nothing is paid but its distance to the wanted one, and the optimum "
    "costs no more. It takes an orbit that itself keeps the soft limits.",
)

NOT_GUARANTEED = (
    "In a steady drift the turn rate changes round the orbit, and inputs held for a step leave it "
    "by a little: there feasibility and fall of the cost are no theorems, only counted.",
    "Airspeed, path angle, height, distance and fence are exact soft constraints: kept wherever "
    "they can be, since a flight may begin outside of them.",
    "What the aircraft makes of commands: its lag lets path-angle rate and acceleration follow "
    "differently, and their common limit, the specific force, is passed for moments.",
    "Gusts, a wind or target that changes, another aircraft than predicted, a solve that ends "
    "before it converges: there the controller's fallback modes hold.",
)

ANALYSIS = (
    "The ellipsoid x'P_rho x <= varrho of the paper's analysis is not part of this problem: there "
    "is no level to certify and no certificate to verify."
)


def as_words() -> str:
    """All of it, for people."""
    lines = [ANALYSIS, "", f"Guaranteed. {PREMISE}"]
    lines += [f"  {index}. {words}" for index, words in enumerate(GUARANTEED, 1)]
    lines += ["", "Not guaranteed."]
    lines += [f"  - {words}" for words in NOT_GUARANTEED]
    return "\n".join(lines)
