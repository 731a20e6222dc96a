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

"""Aircraft that are flown now, over the topics that they and their controllers publish."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

from uav_tracking_mpc.nodes.flight_watcher import FlightWatcher
from uav_tracking_mpc.nodes.ros_environment import exported_domain
from uav_tracking_mpc.nodes.spun_node import SpunNode
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.live.live_sight import live_sight, node_statuses
from uav_tracking_mpc.view.live.ros_steering import RosSteering
from uav_tracking_mpc.view.sight import NodeStatus, Sight
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

ROOT = "uav"  # name of the aircraft without a namespace
PAST_PERIOD, PAST_SPAN = 0.2, 300.0  # s of the flight's clock
STATUS_PERIOD = 0.5  # s of wall time


class LiveFlight(WatchedFlight):
    """One aircraft, as it is heard.

    Args:
        watcher: That listens to it.
        namespace: Of the aircraft, absolute.
    """

    def __init__(self, watcher: FlightWatcher, namespace: str) -> None:
        self.name = namespace.strip("/").replace("/", ".") or ROOT
        self._heard, self._parameters = watcher.aircraft[namespace], watcher.parameters[namespace]
        self.steering = RosSteering(watcher, namespace)
        self._past: deque[Sight] = deque(maxlen=round(PAST_SPAN / PAST_PERIOD))
        self._sight: Sight | None = None
        self._statuses: tuple[NodeStatus, ...] = ()
        self._status_due = 0.0  # steady [s]
        self._lock = threading.Lock()

    @property
    def sight(self) -> Sight | None:
        """What there is to see now; None before the first state."""
        with self._lock:
            return self._look()

    @property
    def tracking(self) -> TrackingParameters | None:
        """What its controller flies by; None before it has answered."""
        return self._parameters.value

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`; without plans and without what the nodes say.

        Args:
            span: How far back from now in [s].
        """
        found: list[Sight] = []
        with self._lock:
            for sight in reversed(self._past):
                if sight.time < self._past[-1].time - span:
                    break
                found.append(sight)
        return found[::-1]

    def _look(self) -> Sight | None:
        """See what is now, and keep it a few times a second."""
        now = time.monotonic()
        if now >= self._status_due:
            self._status_due = now + STATUS_PERIOD
            self._statuses = node_statuses(self._heard, now)
        sight = self._sight = live_sight(self._heard, self._sight, self._statuses, now)
        if sight is None:
            return None
        if self._past and sight.time < self._past[-1].time:
            self._past.clear()  # time began anew
        if not self._past or sight.time >= self._past[-1].time + PAST_PERIOD:
            self._past.append(replace(sight, plan=None, statuses=()))
        return sight


class LiveSource(FlightSource):
    """Every aircraft of a ROS domain, as it appears.

    Args:
        domain: ROS domain; that of the environment by default.

    Raises:
        DomainValueError: The environment names a domain that is none.
    """

    def __init__(self, domain: int | None = None) -> None:
        self._domain = (exported_domain() or 0) if domain is None else domain
        self._spun = SpunNode(FlightWatcher, self._domain)
        self._flights: dict[str, LiveFlight] = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="past of flights", daemon=True)
        self._keeper.start()

    @property
    def words(self) -> str:
        """That nothing flies yet; empty once something does."""
        if any(flight.sight is not None for flight in self.flights()):
            return ""
        return f"waiting for a flight in domain {self._domain}"

    def flights(self) -> Sequence[LiveFlight]:
        """All that were heard so far."""
        watcher = self._spun.node
        with self._lock:
            for namespace in watcher.aircraft:
                if namespace not in self._flights:
                    self._flights[namespace] = LiveFlight(watcher, namespace)
            return list(self._flights.values())

    def close(self) -> None:
        """Listen no longer."""
        self._ended.set()
        self._keeper.join()
        self._spun.close()

    def _keep(self) -> None:
        """Look now and then, so that the past has no gap where no page looks."""
        while not self._ended.wait(PAST_PERIOD):
            for flight in self.flights():
                _ = flight.sight
