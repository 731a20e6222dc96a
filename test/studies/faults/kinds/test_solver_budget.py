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

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.solver_budget import SolverBudget


def test_the_least_budget_is_asked_for_last_and_put_back():
    asked = []
    client = SimpleNamespace(
        ask=lambda values: asked.append(values["solve_time_max"]),
        put_back=lambda: asked.append("put back"),
        settled=False,
    )
    flight, fault = SimpleNamespace(parameters=client), SolverBudget()
    fault.begin(flight, 1.0, 0)
    fault.end(flight)
    assert asked == [*sorted(asked[:-1], reverse=True), "put back"]
    assert not fault.settled(flight)
