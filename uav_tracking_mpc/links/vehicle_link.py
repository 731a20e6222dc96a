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

"""One aircraft that is reached through its autopilot: what every link does."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.link import LinkParameters


class LinkError(RuntimeError):
    """There is no aircraft at the other end, or it is lost; the message says which and why."""


class LinkRefusedError(LinkError):
    """Waiting does not help: the address has another form, or what answers is flown by no link."""


class Sighting(NamedTuple):
    """Where the vehicle to circle was, as it said itself.

    Attributes:
        stamp: In [s], by the link's clock.
        position: In ``map``, shape (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s]; None where it does not tell.
    """

    stamp: float
    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None


@dataclass(frozen=True)
class Inspection:
    """What was found at the other end before the flight.

    Attributes:
        found: What and how much, in words.
        envelope: Parameters of the controller that this vehicle asks for, by name.
        warnings: What the pilot should know.
        refusals: Why it cannot be flown; empty if it can.
    """

    found: Mapping[str, str] = field(default_factory=dict)
    envelope: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    refusals: tuple[str, ...] = ()


class VehicleLink(ABC):
    """One aircraft, reached through its autopilot.

    Times are seconds of one clock, that of :meth:`now`; positions and velocities are those of
    ``map`` (East, North, Up), whatever the autopilot itself uses. As a context manager a link
    connects and closes itself.

    Args:
        address: Where the aircraft is, in words of the link; empty for the usual place.

    Attributes:
        name: By which it is found.
        when_silent: What the aircraft does when commands stop coming, in words.
        holds: Whether the autopilot itself holds altitude and airspeed, so that of the commands
            only the turn rate is flown.
        address: As above.
        identity: Which aircraft it is, as its autopilot says; empty where it is not known.
        events: What has happened since it was last asked.
    """

    name: ClassVar[str]
    when_silent: ClassVar[str]
    holds: ClassVar[bool] = False

    def __init__(self, address: str = "") -> None:
        self.address = address
        self.identity = ""
        self.events = EventLog()

    @classmethod
    def of(cls, parameters: LinkParameters) -> VehicleLink:
        """The link that parameters describe; one that heeds more of them than the address says so.

        Args:
            parameters: Of section ``autopilot_link``.

        Raises:
            LinkError: They describe none.
        """
        return cls(parameters.connection)

    @abstractmethod
    def connect(self, timeout: float) -> None:
        """Reach the aircraft.

        Args:
            timeout: How long to try in [s].

        Raises:
            LinkError: There is none.
            LinkRefusedError: There is one, but not one that can be flown by this link.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the aircraft, which then does as :attr:`when_silent` says."""

    @abstractmethod
    def now(self) -> float:
        """Present time in [s]."""

    @abstractmethod
    def measured(self, timeout: float) -> Measurement | None:
        """The next state of the aircraft, stamped with the time of measuring.

        Args:
            timeout: How long to wait for one in [s].

        Returns:
            None if none came in time.

        Raises:
            LinkError: The aircraft is lost.
        """

    @abstractmethod
    def command(
        self,
        stamp: float,
        inputs: NDArray[np.float64],
        step: float,
        orbit: FlownOrbit | None = None,
    ) -> str:
        """Give the aircraft a plan.

        Args:
            stamp: When the plan begins in [s].
            inputs: (u_psi, u_chi, u_v) at 0, step, 2 step, ... after that, held in between, shape
                (n, 3), in [rad/s], [rad/s] and [m/s^2].
            step: In [s].
            orbit: To which the plan leads: its altitude and airspeed for autopilots that hold
                these themselves, its circle for those that can loiter; None where it is not known.

        Returns:
            Why the aircraft does not fly it, in words; empty if it does.
        """

    def inspect(self) -> Inspection:
        """What is found at the other end, to be asked before the flight.

        Raises:
            LinkError: The aircraft does not answer.
        """
        return Inspection()

    @property
    def engaged(self) -> bool:
        """Whether the aircraft flies the commands."""
        return True

    def engage(self) -> str:
        """Ask the aircraft to fly the commands from now on.

        Returns:
            Why it does not, in words; empty if it does or is about to.
        """
        return ""

    def disengage(self) -> None:  # noqa: B027
        """Command nothing any more; the aircraft then does as :attr:`when_silent` says."""

    def sighting(self) -> Sighting | None:
        """The newest sighting of the vehicle to circle that nobody has taken yet."""
        return None

    def values(self) -> dict[str, object]:
        """What the link measures of itself: names with units, and values."""
        return {}

    def __enter__(self) -> VehicleLink:
        """Connect, within 10 s."""
        self.connect(10.0)
        return self

    def __exit__(self, *error: object) -> None:
        """Close."""
        self.close()
