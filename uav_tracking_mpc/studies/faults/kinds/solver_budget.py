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

"""A time budget that no solve can keep."""

from __future__ import annotations

from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.kinds import Fault

LEAST_BUDGETS = (1e-4, 1e-9)  # s; the least that is accepted stays


class SolverBudget(Fault):
    """Sets the solver's time budget so low that no solve ends in time, and puts it back."""

    name = "solver_budget"
    family = "parameters"
    duration = (1.0, 3.0)

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        for budget in LEAST_BUDGETS:
            flight.parameters.ask({"solve_time_max": budget})

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        flight.parameters.put_back()

    def settled(self, flight: Flight) -> bool:
        """See :meth:`Fault.settled`."""
        return flight.parameters.settled
