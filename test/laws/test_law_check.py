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

"""Every law passes the check, and the check finds what an author gets wrong."""

import numpy as np
import pytest

from uav_tracking_mpc.laws import GUIDANCE_LAW
from uav_tracking_mpc.laws.conformance import check_law
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.parameters.conformance import ConformanceError


@pytest.mark.parametrize("name", GUIDANCE_LAW.names)
def test_every_law_passes(name):
    check_law(GUIDANCE_LAW.find(name))


def wrong(**members):
    """A law with these members."""
    return type("Wrong", (VectorField,), members)


def backwards(self, situation):
    turn, climb, acceleration = VectorField.inputs(self, situation)
    return np.array([-turn, climb, acceleration])


def undefined(self, situation):
    """The direction to the target has no value straight above it."""
    x, y, _ = situation.offset
    return VectorField.inputs(self, situation) * (x / x + y / y)


def meddling(self, situation):
    situation.vehicle[0] += 1.0
    return VectorField.inputs(self, situation)


def learning(self, situation):
    """Has a memory that all of its class share."""
    type(self).asked += 1
    return VectorField.inputs(self, situation) / self.asked


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"inputs": backwards}, "m from the target: do its signs agree"),
        (
            {"sense": property(lambda _: 1.0, lambda *_: None)},
            "it does not circle clockwise: does it heed",
        ),
        (
            {"inputs": lambda *asked: 5.0 * VectorField.inputs(*asked)},
            "is outside the envelope; see Envelope.clip",
        ),
        ({"inputs": undefined}, r"0 m East, .*is \[nan, nan, nan\], must be finite"),
        ({"inputs": lambda *_: 1 / 0}, "case 0, .*ZeroDivisionError: division by zero"),
        ({"__init__": lambda *_: 1 / 0}, "vector_field: ZeroDivisionError"),
        ({"inputs": meddling}, "has changed the situation"),
        ({"inputs": learning, "asked": 0}, "another law of the same orbit answers differently"),
    ],
)
def test_what_is_wrong_is_said(members, words):
    with np.errstate(all="ignore"), pytest.raises(ConformanceError, match=words):
        check_law(wrong(**members))
