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

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.mpc.solver import shift

SAMPLES = np.column_stack([np.arange(6.0), np.arange(6.0) ** 2])


def test_whole_stages_move_the_samples_and_hold_the_last():
    np.testing.assert_array_equal(shift(SAMPLES, 2.0), SAMPLES[[2, 3, 4, 5, 5, 5]])


def test_no_time_changes_nothing():
    np.testing.assert_array_equal(shift(SAMPLES, 0.0), SAMPLES)


@given(st.floats(0.0, 20.0))
def test_a_straight_line_stays_a_straight_line(stages):
    np.testing.assert_allclose(
        shift(SAMPLES, stages)[:, 0], np.minimum(np.arange(6) + stages, 5.0), atol=1e-12
    )
