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

"""An aircraft that a page shows: what there is to see and to ask, and where it comes from."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.settings.tracking import TrackingParameters

CONTROLLER = "nmpc_controller"
SIMULATOR = "uav_simulator"
TARGET = "target_publisher"
SILENT = 3  # level of a node that says nothing, as in diagnostic_msgs
PAST_PERIOD = 0.2  # s of the flight's clock between sights of its past
PAST_KEPT = 2000  # sights of a record's past that are not read again
RATES = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # speeds of a replay and of simulated time [-]


@dataclass(frozen=True)
class TargetSight:
    """The target at one time.

    Attributes:
        position: Where the controller takes it to be, else where it was measured, in ``map``, shape
            (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s]; None where it is not known.
        std: Standard deviation of ``position`` on each axis in [m], nan where it is not known.
        measured: Newest measurement in ``map``, shape (3,), in [m]; None where there is none.
        truth: Where it truly is in ``map``, shape (3,), in [m]; None where nobody says so.
        forecast: Where it is expected from now on and the standard deviation of that on each axis,
            (x, y, z, std), shape (n, 4), in [m]; None where nobody says so.
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None = None
    std: float = math.nan
    measured: NDArray[np.float64] | None = None
    truth: NDArray[np.float64] | None = None
    forecast: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class NodeStatus:
    """What a node says of itself.

    Attributes:
        node: Its name.
        level: 0 ok, 1 warning, 2 error, 3 silent, as in diagnostic_msgs.
        words: What people read.
        values: Further figures, as text with units.
    """

    node: str
    level: int
    words: str
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class RivalSight:
    """What a guidance law flies beside an aircraft, in the same air about the same target.

    Attributes:
        law: Its name.
        position: In ``map``, shape (3,), in [m].
        heading: In [rad].
        path_angle: In [rad], positive up.
        bank: In [rad], positive to the right.
        range_error: Distance to the target less the one that is asked for, in [m].
    """

    law: str
    position: NDArray[np.float64]
    heading: float
    path_angle: float
    bank: float
    range_error: float


@dataclass(frozen=True)
class Sight:
    """One aircraft at one time.

    Attributes:
        time: Of the flight's clock in [s].
        position: In ``map``, shape (3,), in [m].
        heading: psi of the velocity through the air in [rad].
        path_angle: chi of it in [rad], positive up.
        bank: In [rad], positive to the right.
        airspeed: In [m/s], nan where it is not known.
        ground_velocity: In ``map``, shape (3,), in [m/s].
        wind: In ``map``, shape (3,), in [m/s]; None where it is not known.
        target: None before it is known.
        wanted: The orbit that is asked for; None before the target is known.
        flown: The orbit that the plan ends on; None where there is none.
        plan: Planned positions from now on, shape (n, 3), in [m]; None where there is none.
        mode: What is flown; None before the first command.
        reason: Why it is not optimal, in words; empty if it is.
        errors: Of range [m], bearing [rad], altitude [m], path angle [rad], speed [m/s], by the
            names ``range_error`` and so on; empty before the target is known.
        cost: Optimal cost [-], nan where there is none.
        solve_time: Of the newest solve in [s], nan where there is none.
        latency: From a state's stamp to its command in [s], nan where it is not measured.
        statuses: What the nodes say of themselves.
        rivals: What guidance laws fly beside it; empty unless that was asked for.
    """

    time: float
    position: NDArray[np.float64]
    heading: float
    path_angle: float
    bank: float
    airspeed: float
    ground_velocity: NDArray[np.float64]
    wind: NDArray[np.float64] | None = None
    target: TargetSight | None = None
    wanted: FlownOrbit | None = None
    flown: FlownOrbit | None = None
    plan: NDArray[np.float64] | None = None
    mode: FallbackMode | None = None
    reason: str = ""
    errors: Mapping[str, float] = field(default_factory=dict)
    cost: float = math.nan
    solve_time: float = math.nan
    latency: float = math.nan
    statuses: tuple[NodeStatus, ...] = ()
    rivals: tuple[RivalSight, ...] = ()


class PlayClock:
    """Time between the begin and the end of a record.

    Args:
        begin: First time in [s].
        end: Last time in [s].
        now: Steady wall time in [s].

    Attributes:
        begin: First time in [s].
        end: Last time in [s].
    """

    def __init__(self, begin: float, end: float, now: Callable[[], float] = time.monotonic) -> None:
        self.begin, self.end, self._now = begin, end, now
        self._from, self._since = begin, now()
        self._rate, self._playing = 1.0, True

    @property
    def time(self) -> float:
        """Where the record stands in [s]."""
        if not self._playing:
            return self._from
        return min(self._from + self._rate * (self._now() - self._since), self.end)

    @property
    def playing(self) -> bool:
        """Whether it goes on; it stands at the end."""
        return self._playing and self.time < self.end

    @property
    def rate(self) -> float:
        """Recorded over wall time [-]."""
        return self._rate

    @rate.setter
    def rate(self, rate: float) -> None:
        """Play at another rate from now on [-]."""
        self.seek(self.time)
        self._rate = rate

    def seek(self, time: float) -> None:
        """Go to a time; it plays on from there if it played.

        Args:
            time: In [s]; the nearest one of the record is taken.
        """
        self._from, self._since = min(max(time, self.begin), self.end), self._now()

    def play(self, rate: float | None = None) -> None:
        """Go on, from the begin where it stood at the end.

        Args:
            rate: Recorded over wall time [-], positive; unchanged by default.
        """
        at_end = self.time >= self.end
        self.seek(self.begin if at_end and not self.playing else self.time)
        self._playing = True
        self._rate = self._rate if rate is None else rate

    def pause(self) -> None:
        """Stand still."""
        self.seek(self.time)
        self._playing = False


class Steering(ABC):
    """Requests of one aircraft.

    Attributes:
        nodes: Whose parameters can be changed: of CONTROLLER, SIMULATOR, TARGET. A real autopilot
            has no SIMULATOR, a tracker no TARGET; neither is steered then.
        faults: Faults that can be injected, by name, and what each does, in words.
        comparable: Whether guidance laws can be flown beside.
    """

    nodes: frozenset[str] = frozenset()
    faults: Mapping[str, str] = {}
    comparable: bool = False

    def compare(self, on: bool) -> str:
        """Fly the guidance laws beside, from where the aircraft is, or no longer.

        Args:
            on: Whether they are to fly.

        Returns:
            Why it was refused; empty where it was done.
        """
        return "guidance laws are flown beside a simulation alone"

    @abstractmethod
    def parameters(self, node: str) -> Mapping[str, Any]:
        """Values of a node's parameters as they are now, by name.

        Args:
            node: One of ``nodes``.
        """

    @abstractmethod
    def change(self, node: str, /, **values: Any) -> str:
        """Change parameters as a whole, or not at all.

        Args:
            node: One of ``nodes``.
            values: By name.

        Returns:
            Why it was refused, in the node's own words; empty where it was done.
        """

    @abstractmethod
    def send_target(self, east: float, north: float) -> str:
        """Send the target somewhere, to stand there at the height that it has.

        Args:
            east: In ``map`` in [m].
            north: In ``map`` in [m].

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def pause(self, still: bool) -> str:
        """Stop simulated time, or let it go on.

        Args:
            still: Whether it is to stand.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def reset(self) -> str:
        """Put the simulated aircraft back where it started.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def engage(self, on: bool) -> str:
        """Let the controller command, or keep it silent.

        Args:
            on: Whether it is to command.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def inject(self, fault: str) -> str:
        """Let a fault happen, and end after some seconds by itself.

        Args:
            fault: One of ``faults``.

        Returns:
            Why it was refused; empty where it began.
        """


class WatchedFlight(ABC):
    """One aircraft.

    Attributes:
        name: Its namespace without slashes, or what was flown; one word, its own in a source.
        steering: None where nothing can be steered.
        tracking: What its controller flies by, with its limits; None before that is known.
    """

    name: str
    tracking: TrackingParameters | None = None
    steering: Steering | None = None

    @property
    @abstractmethod
    def sight(self) -> Sight | None:
        """What there is to see now; None before the first state."""

    @abstractmethod
    def past(self, span: float) -> Sequence[Sight]:
        """What there was to see, oldest first, a few a second: for tracks and plots.

        Args:
            span: How far back from now in [s].
        """

    def at(self, time: float, whole: bool = True) -> Sight | None:
        """What a record holds of a time; None where it holds nothing, or nothing is recorded.

        Args:
            time: In [s] of the record.
            whole: With plan and statuses, which may take long to read.
        """
        return None


class FlownFlight(WatchedFlight):
    """One aircraft that is flown now: a few sights a second stay, without plans and statuses.

    Args:
        span: How far back they are kept in [s].
    """

    def __init__(self, span: float) -> None:
        self._kept: deque[Sight] = deque(maxlen=round(span / PAST_PERIOD))
        self._kept_lock = threading.Lock()  # others look while it is flown

    def keep(self, sight: Sight) -> None:
        """Keep a sight, if the last one is long enough ago; where time began anew, so does this.

        Args:
            sight: Of now.
        """
        with self._kept_lock:
            if self._kept and sight.time < self._kept[-1].time:
                self._kept.clear()
            if not self._kept or sight.time >= self._kept[-1].time + PAST_PERIOD - 1e-9:
                self._kept.append(replace(sight, plan=None, statuses=()))

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`.

        Args:
            span: How long before the last one in [s].
        """
        with self._kept_lock:
            last = self._kept[-1].time if self._kept else 0.0
            return [sight for sight in self._kept if sight.time >= last - span]


class KeptFlight(WatchedFlight):
    """One aircraft of a record, shown at the time of a clock.

    Args:
        name: Of the aircraft.
        clock: What time it is in the record.
        tracking: What its controller flew by; None where nobody knows.
    """

    def __init__(self, name: str, clock: PlayClock, tracking: TrackingParameters | None) -> None:
        self.name, self.clock, self.tracking = name, clock, tracking
        self._past: OrderedDict[int, Sight | None] = OrderedDict()

    @property
    def sight(self) -> Sight | None:
        """What there is to see at the time of the clock."""
        return self.at(self.clock.time)

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`; plans and statuses are left out.

        Args:
            span: How far back from now in [s].
        """
        now = self.clock.time
        # Whole periods: as time goes on, the same sights are asked for again.
        last = math.floor(now / PAST_PERIOD)
        first = math.ceil(max(now - span, self.clock.begin) / PAST_PERIOD)
        sights: list[Sight] = []
        for turn in range(first, last + 1):
            if turn not in self._past:
                self._past[turn] = self.at(turn * PAST_PERIOD, whole=False)
            sight = self._past[turn]
            if sight is not None and (not sights or sight.time > sights[-1].time):
                sights.append(sight)
        while len(self._past) > max(PAST_KEPT, last - first + 1):
            self._past.popitem(last=False)
        return sights


class FlightSource(ABC):
    """Aircraft that are flown or were.

    Attributes:
        clock: Of a record; None where the flight is flown now.
    """

    clock: PlayClock | None = None

    @property
    def words(self) -> str:
        """What people read while there is nothing to see, such as what is waited for."""
        return ""

    @abstractmethod
    def flights(self) -> Sequence[WatchedFlight]:
        """All that are known now; the same objects each time."""

    @abstractmethod
    def close(self) -> None:
        """Let go of what the source holds."""
