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

"""Prove a quadratic bound on all of X_f: halve boxes until each one passes its test.

The boxes form a tree. Its root holds X_f; a node is a box that was halved, a leaf one on which the
bound is proved. Written in preorder, one character a node (the coordinate that was halved, or a dot
for a leaf), the tree is the proof's certificate: it covers the root by construction, and whoever
distrusts the search needs only to test the leaves again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uav_tracking_mpc.terminal.ball import PRECISION, flint
from uav_tracking_mpc.terminal.box_check import BoxTest
from uav_tracking_mpc.terminal.quadratic_bound import QuadraticBound

DEPTH_LIMIT = 80
BOXES = 20_000  # budget of a proof, ten seconds of an idle core; a loaded one finds the same, later


@dataclass(frozen=True)
class Stuck:
    """Where a proof stopped.

    Attributes:
        reason: In words.
        center: Middle of the box, error coordinates, length 5 [m, rad, m, rad, m/s].
        half: Its half-widths, length 5, likewise [m, rad, m, rad, m/s].
        excess: Bound for the left side minus the right one there [-].
    """

    reason: str
    center: tuple[float, ...]
    half: tuple[float, ...]
    excess: float


@dataclass(frozen=True)
class Proof:
    """Outcome: proved, or not proved and where it got stuck.

    It never says "false": only a counterexample does, and looking for one is not done here.

    Attributes:
        proved: The bound holds for every x of X_f.
        half: Half-widths of the root box, length 5 [m, rad, m, rad, m/s].
        tree: The boxes in preorder (empty unless proved).
        multipliers: m of the test on each leaf [-], in the order of the tree (empty unless
            proved).
        boxes: Boxes tested.
        leaves: Boxes on which the bound was proved.
        depth: Largest number of halvings.
        stuck: Where it stopped, if it did.
    """

    proved: bool
    half: tuple[float, ...]
    tree: str
    multipliers: tuple[float, ...]
    boxes: int
    leaves: int
    depth: int
    stuck: Stuck | None = None


def prove(bound: QuadraticBound, box_limit: int = BOXES) -> Proof:
    """Prove the bound on x' P x <= varrho.

    Args:
        bound: What to prove.
        box_limit: Give up after so many boxes.
    """
    module = flint()
    with module.ctx.workprec(PRECISION):
        test = BoxTest(bound)
        half = test.root()
        stack = [(np.zeros(len(half)), half, 0, 0.0)]
        tree: list[str] = []
        multipliers: list[float] = []
        leaves = boxes = depth = 0
        share = 0.0
        stuck = None
        while stack:
            center, width, level, multiplier = stack.pop()
            verdict = test(center, width, multiplier)
            boxes += 1
            depth = max(depth, level)
            if verdict.proved:
                tree.append(".")
                multipliers.append(verdict.multiplier)
                leaves += 1
                share += 0.5**level
                continue
            reason = None
            if level >= DEPTH_LIMIT:
                reason = (
                    f"a box halved {DEPTH_LIMIT} times still fails: the bound is tight or false"
                )
            elif boxes >= box_limit:
                reason = (
                    f"the budget of {box_limit} boxes is spent, {share:.1%} of the volume "
                    "proved; a larger one (--boxes) may do"
                )
            if reason is None:
                width = width.copy()
                width[verdict.cut] /= 2.0
                if not _exact_sum(center[verdict.cut], width[verdict.cut]):
                    reason = "boxes got too small to be halved exactly: the bound is tight or false"
            if reason is not None:
                stuck = Stuck(reason, tuple(center.tolist()), tuple(width.tolist()), verdict.excess)
                break
            tree.append(str(verdict.cut))
            for side in (1.0, -1.0):
                child = center.copy()
                child[verdict.cut] += side * width[verdict.cut]
                stack.append((child, width, level + 1, verdict.multiplier))
    return Proof(
        proved=stuck is None,
        half=tuple(half.tolist()),
        tree="".join(tree) if stuck is None else "",
        multipliers=tuple(multipliers) if stuck is None else (),
        boxes=boxes,
        leaves=leaves,
        depth=depth,
        stuck=stuck,
    )


def _exact_sum(center: float, width: float) -> bool:
    """Whether center + width and center - width are doubles: the error of the rounded sum is 0."""
    for part in (width, -width):
        total = center + part
        back = total - center
        if (center - (total - back)) + (part - back) != 0.0:
            return False
    return True
