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

"""Faults of nodes: killed, frozen, starved by busy processes, asked for wrong parameters."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.parameters.specification import Specification, Value
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.faults.node_campaign import NodeCampaign

RESTART_LIMIT = 60.0  # s of wall time for a node that was killed to be heard again
PER_CORE = 2  # processes that load a core
# Ends by itself, for nobody ends it when the campaign itself is killed.
BUSY = "import time\nend = time.monotonic() + 10.0\nwhile time.monotonic() < end: pass"


class ProcessFault(Fault):
    """A fault of one node's process.

    Args:
        victim: The node.
    """

    family = "process"
    wall_time = True

    def __init__(self, victim: str) -> None:
        self.victim, self.variant = victim, f"{self.name}_{victim}"

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each node."""
        return [cls(node) for node in NODES]


class Kill(ProcessFault):
    """Kills a node's process and starts it anew: it must be heard again.

    Loading takes wall time, which is no time of flight: the fault has settled when the new process
    is heard.
    """

    name = "kill"
    duration = (0.0, 1.0)
    restarts = True
    _started: float | None = None

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.supervisor.kill(self.victim)

    def end(self, flight: NodeCampaign) -> None:
        """See :meth:`Fault.end`."""
        flight.supervisor.restart(self.victim)
        self._started = time.monotonic()

    def settled(self, flight: NodeCampaign) -> bool:
        """See :meth:`Fault.settled`."""
        assert self._started is not None
        return self._overdue or flight.observer.heard.get(self.victim, 0.0) >= self._started

    def violations(self, flight: NodeCampaign) -> list[Violation]:
        """See :meth:`Fault.violations`."""
        if not self._overdue:
            return []
        words = f"{self.victim} was not heard within {RESTART_LIMIT:g} s of its new start"
        return [Violation("restart", words)]

    @property
    def _overdue(self) -> bool:
        return self._started is not None and time.monotonic() - self._started > RESTART_LIMIT


class Stop(ProcessFault):
    """Freezes a node's process and lets it go on."""

    name = "stop"
    duration = (0.5, 3.0)

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.supervisor.freeze(self.victim)

    def end(self, flight: NodeCampaign) -> None:
        """See :meth:`Fault.end`."""
        flight.supervisor.thaw(self.victim)


class CpuStarvation(Fault):
    """Starts two busy processes for every core and ends them."""

    name = "cpu_starvation"
    family = "process"
    duration = (0.5, 2.0)
    wall_time = True

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        program = [sys.executable, "-S", "-c", BUSY]
        self._busy = [
            subprocess.Popen(program, stdin=subprocess.DEVNULL)
            for _ in range(PER_CORE * (os.cpu_count() or 1))
        ]

    def end(self, flight: NodeCampaign) -> None:
        """See :meth:`Fault.end`."""
        for process in self._busy:
            process.kill()
            process.wait()


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

    def end(self, flight: NodeCampaign) -> None:
        """See :meth:`Fault.end`."""
        flight.parameters.put_back()

    def settled(self, flight: NodeCampaign) -> bool:
        """See :meth:`Fault.settled`."""
        return flight.parameters.settled


class ParameterStorm(ParameterFault):
    """Asks the controller for parameters, sane and absurd, and puts back what was accepted.

    A node whose parameters are read-only refuses it all, which is an answer too.
    """

    name = "parameter_storm"

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._rng = random.Random(seed)
        self._asked = 0.0

    def during(self, flight: NodeCampaign) -> None:
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

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        for budget in LEAST_BUDGETS:
            flight.parameters.ask({"solve_time_max": budget})
