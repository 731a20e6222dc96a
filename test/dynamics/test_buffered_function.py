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

"""A function on its own arrays gives what the call gives."""

import casadi as ca
import numpy as np

from uav_tracking_mpc.dynamics.buffered_function import BufferedFunction

x, y = ca.SX.sym("x", 2, 3), ca.SX.sym("y")
PRODUCT = ca.Function("product", [x, y], [ca.densify(x.T * y), ca.sin(y)])


def test_arguments_are_read_and_results_are_written_by_columns():
    buffered = BufferedFunction(PRODUCT)
    values = np.arange(6.0).reshape(2, 3)
    buffered.arguments[0][:], buffered.arguments[1][0] = values.ravel(order="F"), 2.0
    buffered.evaluate()
    whole, sine = (np.array(result) for result in PRODUCT(values, 2.0))
    np.testing.assert_array_equal(buffered.results[0], whole.ravel(order="F"))
    np.testing.assert_array_equal(buffered.results[1], sine.ravel())


def test_a_given_array_is_read_as_it_is_when_evaluated():
    given = np.zeros((3, 2))  # of the transposed shape: the same numbers in the same order
    buffered = BufferedFunction(PRODUCT, [given])
    buffered.arguments[1][0] = 1.0
    given[:] = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    buffered.evaluate()
    np.testing.assert_array_equal(buffered.results[0].reshape(2, 3), given.T)
