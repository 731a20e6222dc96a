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

"""A digest changes with what an object holds, however deep, and with nothing else."""

from collections import deque

import numpy as np
from fingerprint import fingerprint

from uav_tracking_mpc.estimation.navigator import CommandHistory
from uav_tracking_mpc.estimation.target_filter import TargetFilter


def test_values_arrays_and_objects_count():
    history = CommandHistory(1.0)
    filtered = TargetFilter(0.1, 0.5)
    before = fingerprint([history, filtered, 1])
    assert fingerprint([history, filtered, 1]) == before
    assert fingerprint([history, filtered, 2]) != before
    history.add(0.0, 0.0, np.zeros((1, 3)), 1.0)
    added = fingerprint([history, filtered, 1])
    assert added != before
    *_, inputs, _ = history._plans[0]
    inputs[0][2] = 1e-300
    assert fingerprint([history, filtered, 1]) != added
    filtered.update(0.0, [1.0, 2.0, 3.0])
    assert fingerprint([filtered]) != fingerprint([TargetFilter(0.1, 0.5)])


def test_what_may_change_is_left_out():
    filtered = TargetFilter(0.1, 0.5)
    before = fingerprint([filtered], ["rejected"])
    filtered.rejected += 1
    assert fingerprint([filtered], ["rejected"]) == before


def test_numbers_that_look_alike_differ():
    things = [0.0, -0.0, 0, False, None, "0", float("nan"), [], (0,), deque([0, 0]), {0: 0}]
    assert len({fingerprint([thing]) for thing in things}) == len(things)
