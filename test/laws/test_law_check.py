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


class Backwards(VectorField):
    def inputs(self, situation):
        turn, climb, acceleration = super().inputs(situation)
        return np.array([-turn, climb, acceleration])


class OneWay(VectorField):
    def __init__(self, orbit, envelope):
        super().__init__(orbit, envelope)
        self.sense = 1.0


class Unclipped(VectorField):
    def inputs(self, situation):
        return 5.0 * super().inputs(situation)


class Undefined(VectorField):
    """The direction to the target has no value straight above it."""

    def inputs(self, situation):
        x, y, _ = situation.offset
        return super().inputs(situation) * (x / x + y / y)


class Raising(VectorField):
    def inputs(self, situation):
        raise ZeroDivisionError("division by zero")


class Meddling(VectorField):
    def inputs(self, situation):
        situation.vehicle[0] += 1.0
        return super().inputs(situation)


class Learning(VectorField):
    """Has a memory that all of its class share."""

    asked = 0

    def inputs(self, situation):
        Learning.asked += 1
        return super().inputs(situation) / Learning.asked


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (Backwards, "m from the target: do its signs agree"),
        (OneWay, "it does not circle clockwise: does it heed"),
        (Unclipped, "is outside the envelope; see Envelope.clip"),
        (Undefined, r"0 m East, .*is \[nan, nan, nan\], must be finite"),
        (Raising, "case 0, .*ZeroDivisionError: division by zero"),
        (Meddling, "has changed the situation"),
        (Learning, "another law of the same orbit answers differently"),
    ],
)
def test_what_is_wrong_is_said(law, words):
    with np.errstate(all="ignore"), pytest.raises(ConformanceError, match=words):
        check_law(law)
