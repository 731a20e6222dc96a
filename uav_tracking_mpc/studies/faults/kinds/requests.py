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

"""Parameters set many times a second, and a time budget that no solve can keep."""

from __future__ import annotations

import random
import time
from typing import Any

from uav_tracking_mpc.parameters.specification import Specification, Value
from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.kinds import Fault

PERIOD = 0.02  # s of wall time between requests, at least
ABSURD_SHARE = 0.6  # -, of the values
ABSURD: tuple[Any, ...] = (
    float("nan"),
    float("inf"),
    -1e300,
    0.0,
    -1,
    2**62,
    True,
    "",
    "banana" * 100,
    [1.0],
    [float("nan")] * 5,
    ["a", "b"],
)
LEAST_BUDGETS = (1e-4, 1e-9)  # s; the least that is accepted stays
# What the observer holds the commands to is not widened.
LIMITS = ("yaw_rate_max", "pitch_rate_max", "acceleration_min", "acceleration_max")


class ParameterFault(Fault):
    """A fault that sets parameters of the controller, and puts back what was accepted."""

    family = "parameters"
    duration = (1.0, 3.0)

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        flight.parameters.put_back()

    def settled(self, flight: Flight) -> bool:
        """See :meth:`Fault.settled`."""
        return flight.parameters.settled


class ParameterStorm(ParameterFault):
    """Asks the controller for parameters, sane and absurd, and puts back what was accepted.

    A node whose parameters are read-only refuses it all, which is an answer too.
    """

    name = "parameter_storm"

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._rng = random.Random(seed)
        self._asked = 0.0

    def during(self, flight: Flight) -> None:
        """See :meth:`Fault.during`: asks for one to four parameters at random, at once."""
        now = time.monotonic()
        if now - self._asked < PERIOD:
            return
        self._asked = now
        rng, client = self._rng, flight.parameters
        values: dict[str, Any] = {
            known.name: rng.choice(ABSURD)
            if rng.random() < ABSURD_SHARE
            else sane(known, client.configured[known.name], rng)
            for known in rng.sample(client.known, rng.randint(1, 4))
        }
        if rng.random() < 0.1:
            values[rng.choice(("use_sim_time", "no_such_parameter"))] = rng.choice(ABSURD)
        client.ask(values)


def sane(known: Specification, configured: Value, rng: random.Random) -> Value:
    """A value that could be meant.

    Args:
        known: The parameter.
        configured: Its value as configured.
        rng: For the choice.

    Returns:
        One of its choices, or a number within 10 % of the configured one.
    """
    if known.choices:
        return rng.choice(known.choices)
    if not isinstance(configured, float):
        return configured
    return configured * rng.uniform(0.9, 1.0 if known.name in LIMITS else 1.1)


class SolverBudget(ParameterFault):
    """Sets the solver's time budget so low that no solve ends in time, and puts it back."""

    name = "solver_budget"

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        for budget in LEAST_BUDGETS:
            flight.parameters.ask({"solve_time_max": budget})
