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

"""Names of a vector's parts, and of parts of these."""

import casadi as ca
import numpy as np

from uav_tracking_mpc.symbolic.layout import Layout

INNER = Layout(left=1, right=2)
OUTER = Layout(first=2, inner=INNER, last=1)


def test_parts_are_views_of_the_vector():
    vector = np.arange(6.0)
    parts = OUTER.parts(vector)
    assert parts.inner.right.tolist() == [3.0, 4.0]
    parts.inner.left[:] = 7.0
    assert vector.tolist() == [0.0, 1.0, 7.0, 3.0, 4.0, 5.0]
    assert OUTER.part("inner", vector).tolist() == [7.0, 3.0, 4.0]


def test_a_layout_begins_with_the_numbers_of_its_parts():
    assert Layout(first=[1.0, 2.0], inner=OUTER, last=1).begin.tolist() == [1.0, 2.0, *[0.0] * 7]
    assert Layout(inner=Layout(last=[3.0])).begin.tolist() == [3.0]


def test_parts_of_symbols_make_the_column_again():
    column, parts = OUTER.symbol("column")
    assert ca.is_equal(OUTER.joined(parts), ca.densify(column))
