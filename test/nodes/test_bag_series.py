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

"""Values are put beside the states and commands that they came with."""

import numpy as np

from uav_tracking_mpc.nodes.bag_series import beside_commands, latency


def test_latency_is_from_a_state_to_the_command_that_answers_it():
    states = [(1, 1_000), (2, 2_000), (3, 3_000)]
    found = latency(states, [(1, 2_000), (3, 7_000), (9, 8_000)])
    assert (found.median, found.max) == (2.5, 4.0)
    assert latency(states, [(9, 8_000)]) is None


def test_a_value_belongs_to_the_command_before_it():
    np.testing.assert_array_equal(
        beside_commands([10, 20, 30], [(5, 1.0), (11, 2.0), (35, 3.0)]), [2.0, np.nan, 3.0]
    )
