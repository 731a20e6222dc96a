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

"""Every fault passes the check, and the check finds what an author gets wrong."""

import random
from pathlib import Path

import pytest

from uav_tracking_mpc.parameters.conformance import ConformanceError
from uav_tracking_mpc.studies.faults.kinds import FAULT
from uav_tracking_mpc.studies.faults.kinds.conformance import check_fault
from uav_tracking_mpc.studies.faults.kinds.messages import Loss

EXAMPLE = f"{Path(__file__).parents[4] / 'examples' / 'add_a_fault.py'}:IcedPitot"


@pytest.mark.parametrize("name", [*FAULT.own_names, EXAMPLE])
def test_every_fault_passes(name):
    check_fault(FAULT.find(name))


def wrong(**members):
    return type("Wrong", (Loss,), {"name": "wrong", **members})


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (wrong(name=""), "Wrong has no `name`"),
        (wrong(variants=classmethod(lambda cls: [])), "no variants"),
        (wrong(variants=classmethod(lambda cls: [cls(), cls()])), "called alike"),
        (wrong(duration=(3.0, 1.0)), "duration"),
        (wrong(deliver=lambda self, topic, data: [(-1.0, data)]), "-1.0 s late"),
        (wrong(deliver=lambda self, topic, data: [(random.random(), data)]), "the same seed"),
        (wrong(deliver=lambda self, topic, data: [(0.0, b"")]), "wrong: "),
        (wrong(deliver=lambda self, topic, data: 1 / 0), "ZeroDivisionError"),
    ],
)
def test_what_is_wrong_is_said(fault, words):
    with pytest.raises(ConformanceError, match=words):
        check_fault(fault)
