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

"""Faults that a campaign injects.

===============  ==============================================================================
``conformance``  whether a fault keeps what the base asks for
``messages``     lost, late, repeated, out of turn: loss, silence, jitter, duplicated, reordered;
                 with another stamp or frame, or with numbers that are none or that no flight has:
                 corruption, clock_jump, target_teleport
``nodes``        killed or frozen, starved by busy processes: kill, stop, cpu_starvation; asked for
                 parameters: parameter_storm, solver_budget
===============  ==============================================================================

A fault is a subclass of :class:`Fault`. It is found by its ``name``, by an entry point in the group
``uav_tracking_mpc.studies.faults.kinds``, or as ``path.py:Class``
(``uav_tracking torture --fault path.py:Class``). What strikes messages derives from one of the
bases in :mod:`uav_tracking_mpc.studies.faults.stream_fault`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from uav_tracking_mpc.parameters.registry import ExtensionPoint
from uav_tracking_mpc.studies.faults.invariants import Violation

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.faults.node_campaign import NodeCampaign


class Fault(ABC):
    """How a fault begins, how it ends, and what must hold meanwhile.

    Every injection gets an object of its own, so a fault may keep what it needs from beginning to
    end in attributes of itself.

    Attributes:
        name: By which the class is found.
        variant: By which this form of the fault is reported; the name where there is only one.
        family: Faults that belong together in tables and figures.
        duration: Shortest and longest time that it lasts [s], of simulated time.
        wall_time: Whether the duration is of wall time instead.
        victim: Node whose process it stops or kills; two faults with a victim never come together,
            for nobody could say which of them did the harm.
        restarts: Whether the victim is started anew: such faults come early in a campaign, so that
            a leak shows in what survives.
        reference: By which the class can be found again in another process.
    """

    name: str
    duration: tuple[float, float]
    wall_time: ClassVar[bool] = False
    restarts: ClassVar[bool] = False
    family: str
    victim: str = ""
    variant: str = ""
    reference: str = ""

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """Every form of the fault, such as one for each node."""
        return (cls(),)

    @property
    def label(self) -> str:
        """By which this form of the fault is reported."""
        return self.variant or self.name

    @abstractmethod
    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
        """Begin.

        Args:
            flight: What the fault acts on.
            seconds: How long it will last, of wall time [s].
            seed: Of everything random in it.
        """

    def during(self, flight: NodeCampaign) -> None:  # noqa: B027 - not every fault needs it
        """Go on; called about 50 times a second of wall time while the fault lasts.

        Args:
            flight: What the fault acts on.
        """

    def end(self, flight: NodeCampaign) -> None:  # noqa: B027 - not every fault needs it
        """End, after the fault's duration or when the campaign is interrupted.

        Args:
            flight: What the fault acts on.
        """

    def settled(self, flight: NodeCampaign) -> bool:
        """Whether its end has taken effect, so that the time to recover begins.

        Args:
            flight: What the fault acts on.
        """
        return True

    def violations(self, flight: NodeCampaign) -> list[Violation]:
        """What must hold from begin to settled and does not, besides every flight's invariants.

        Args:
            flight: What the fault acts on.

        Returns:
            What is violated now; empty while all is well.
        """
        return []


FAULT = ExtensionPoint("fault", Fault)
