"""Links to what flies, one autopilot a file: measurements in, commands out.

==============  ==================================================================
``simulated``   a plant, as if it were behind a radio
==============  ==================================================================

A link is a subclass of :class:`VehicleLink` in a file of its own name. It is found by that name,
by an entry point in the group ``uav_tracking_mpc.links``, or as ``path.py:Class``;
:func:`uav_tracking_mpc.links._check.check_link` tells its author whether it keeps what the base
asks for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement


class LinkError(RuntimeError):
    """There is no aircraft at the other end, or it is lost; the message says which and why."""


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
        address: As above.
    """

    name: ClassVar[str]
    when_silent: ClassVar[str]

    def __init__(self, address: str = "") -> None:
        self.address = address

    @abstractmethod
    def connect(self, timeout: float) -> None:
        """Reach the aircraft.

        Args:
            timeout: How long to try in [s].

        Raises:
            LinkError: There is none, or not one that can be flown by this link.
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
    def command(self, stamp: float, inputs: NDArray[np.float64], step: float) -> str:
        """Give the aircraft a plan.

        Args:
            stamp: When the plan begins in [s].
            inputs: (u_psi, u_chi, u_v) at 0, step, 2 step, ... after that, held in between, shape
                (n, 3), in [rad/s], [rad/s] and [m/s^2].
            step: In [s].

        Returns:
            Why the aircraft does not fly it, in words; empty if it does.
        """

    def __enter__(self) -> VehicleLink:
        """Connect, within 10 s."""
        self.connect(10.0)
        return self

    def __exit__(self, *error: object) -> None:
        """Close."""
        self.close()
