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

"""A check of a sensor on numbers."""

import casadi as ca

from uav_tracking_mpc.symbolic.functions import BufferedFunction


class Evaluated:
    """A check on numbers, with the memory that it writes."""

    def __init__(self, check, layout, memory, sizes):
        known, parts = layout.symbol("known")
        seen = [ca.SX.sym(f"seen{k}", size) for k, size in enumerate(sizes)]
        after, *results = check(parts, *seen)
        written = map(ca.densify, [layout.joined(after), *results])
        function = ca.Function("check", [known, *seen], [*written])
        self._function = BufferedFunction(function, [memory])
        self.memory, self.layout = memory, layout

    def __call__(self, *seen):
        for told, value in zip(self._function.arguments[1:], seen, strict=True):
            told[:] = value
        self._function.evaluate()
        after, *results = self._function.results
        self.memory[:] = after
        return [each.copy() for each in results]
