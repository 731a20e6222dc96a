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

"""Every limit passes the check, and the check finds what an author gets wrong."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from uav_tracking_mpc.limits import LIMIT, Bound, Limit
from uav_tracking_mpc.limits.conformance import check_limit
from uav_tracking_mpc.limits.place import Height
from uav_tracking_mpc.parameters.conformance import ConformanceError
from uav_tracking_mpc.parameters.specification import parameter

EXAMPLE = f"{Path(__file__).parents[2] / 'examples' / 'add_a_limit.py'}:NoFlyCylinder"


@pytest.mark.parametrize("name", [*LIMIT.own_names, EXAMPLE])
def test_every_limit_passes(name):
    check_limit(LIMIT.find(name))


def wrong(base=Limit, **members):
    """A limit with these members."""
    return dataclass(frozen=True)(type("Wrong", (base,), {"name": "wrong", **members}))


def above(self, motion, numbers, xp):
    return Bound(motion.z, lower=0.0)


def at_target(self, motion, numbers, xp):
    return Bound(xp.sqrt(motion.x**2 + motion.y**2), lower=1.0)


def higher_as_symbol(self, motion, numbers, xp):
    return Bound(motion.z + (0.0 if xp is np else 1.0), lower=0.0)


def turning(self, motion, numbers, xp):
    return {"turn": (None, 1.0)}


def upside_down(self, motion, numbers, xp):
    return {"acceleration": (1.0, -1.0)}


class Bare(Limit):
    name = "bare"

    most: float = parameter(1.0, "Greatest height.", "m")

    def stage(self, motion, numbers, xp):
        return Bound(motion.z, upper=numbers[0])


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (type("Nameless", (Limit,), {}), "Nameless has no `name`"),
        (wrong(), "wrong: it limits nothing"),
        (wrong(stage=lambda *_: 3.0), "must be a Bound or None"),
        (wrong(stage=lambda self, motion, *_: Bound(motion.z)), "neither a lower nor an upper"),
        (wrong(stage=lambda self, motion, *_: Bound(motion.z, 0.0, scale=0.0)), "must be above 0"),
        (wrong(stage=at_target), "has no slope"),
        (wrong(stage=higher_as_symbol), "in numbers, .* in symbols"),
        (wrong(stage=above, hard_on_orbit=True), "hard_on_orbit needs orbit"),
        (wrong(stage=above, flown=lambda *_: Bound(1.0, lower=0.0)), "flown.* has shape"),
        (wrong(inputs=turning), "names .'turn'"),
        (wrong(inputs=upside_down), "acceleration of .* is 1.0..-1.0"),
        (wrong(Height, numbers=lambda *_: np.zeros((1, 1))), "numbers.* has shape"),
        (wrong(stage=lambda *_: 1 / 0), "ZeroDivisionError"),
        (Bare, "'most' counts only if Bare is decorated with @dataclass"),
    ],
)
def test_what_is_wrong_is_said(limit, words):
    with pytest.raises(ConformanceError, match=words):
        check_limit(limit)
