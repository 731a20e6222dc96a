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

"""A CasADi function on arrays of its own: a call of the function converts what it is given.

The conversion takes a hundred times as long as evaluating a small function.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray


class BufferedFunction:
    """Fill ``arguments``, call :meth:`evaluate`, read ``results``.

    Args:
        function: Of dense arguments and results.
        arguments: Arrays to read from, C-contiguous, of any shape with as many numbers as the
            argument of the function, which are taken by columns; None, or none at all, for an array
            of its own.

    Attributes:
        arguments: Flat arrays of their own, or those given.
        results: One flat array for each result, by columns, overwritten each time.
    """

    def __init__(
        self, function: ca.Function, arguments: Sequence[NDArray[np.float64] | None] = ()
    ) -> None:
        given = [*arguments, *[None] * (function.n_in() - len(arguments))]
        self.arguments = [
            np.zeros(function.nnz_in(k)) if array is None else array
            for k, array in enumerate(given)
        ]
        self.results = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
        self._buffer, self._evaluate = function.buffer()
        for k, array in enumerate(self.arguments):
            self._buffer.set_arg(k, memoryview(array.reshape(-1)))  # type: ignore
        for k, array in enumerate(self.results):
            self._buffer.set_res(k, memoryview(array))  # type: ignore

    def evaluate(self) -> None:
        """Write the results of the arguments as they are."""
        self._evaluate()
