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

"""Aircraft that are flown now: seen and steered over topics, services and parameters of ROS."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.diagnostic_values import reported_mode
from uav_tracking_mpc.nodes.ros.endpoints import NewestMessage
from uav_tracking_mpc.nodes.ros.process import BackgroundNode
from uav_tracking_mpc.nodes.ros.ros_environment import exported_domain
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.nodes.watching import (
    FlightWatcher,
    HeardAircraft,
    NoAnswerError,
    SteeringRequests,
)
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.snapshot import flown_mode, heard_sight, number
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    PAST_PERIOD,
    SILENT,
    SIMULATOR,
    TARGET,
    FlightSource,
    FlownFlight,
    NodeStatus,
    Sight,
    Steering,
)

T = TypeVar("T")
STALE = 1.5  # s of wall time after which what comes many times a second counts as silent
LATE_REPORT = 2.5  # s after which a node may no longer be as it said: it reports once a second
GONE = 5.0  # s after which a node counts as silent
ROOT = "uav"  # name of the aircraft without a namespace
PAST_SPAN = 300.0  # s of the flight's clock
ENGAGE = f"{CONTROLLER}/engage"
PAUSE = f"{SIMULATOR}/pause"
RESET = f"{SIMULATOR}/reset"
# By name: the service that lets it happen, and what it does. None needs this process at its end.
FAULTS = {
    "target lost": (f"{TARGET}/lose_target", "nothing measures the target for 15 s"),
    "state lost": (f"{SIMULATOR}/lose_state", "no state of the aircraft is published for 15 s"),
    "controller killed": (
        f"{CONTROLLER}/kill",
        "SIGKILL to the process of the controller, which is then started again",
    ),
}


def live_sight(
    heard: HeardAircraft, before: Sight | None, statuses: tuple[NodeStatus, ...], now: float
) -> Sight | None:
    """What there is to see now.

    Args:
        heard: What the aircraft, its controller and its target said.
        before: What was seen before; it stays where nothing new comes.
        statuses: What the nodes say of themselves.
        now: Steady time in [s].

    Returns:
        None before the first state.
    """
    state = _fresh(heard.state, now)
    if state is not None:
        return _seen(heard, state, statuses, now)
    if before is None:
        return None
    # The controller knows whether time stands still or the state is lost.
    report = heard.reports.get(CONTROLLER)
    mode, reason = FallbackMode.SILENCE, heard.state.trouble
    if not reason:
        reason = f"nothing comes on {ODOMETRY.name} for {now - heard.state.arrival:.0f} s"
    if report is not None and now - report.arrival <= LATE_REPORT:
        mode, reason = (reported_mode(report.values) or (mode, ""))[0], report.words
    return replace(before, mode=mode, reason=reason, plan=None, flown=None, statuses=statuses)


def node_statuses(heard: HeardAircraft, now: float) -> tuple[NodeStatus, ...]:
    """What the nodes of an aircraft say of themselves; those that say no more are silent.

    Args:
        heard: Of the aircraft.
        now: Steady time in [s].
    """
    return tuple(
        NodeStatus(report.node, SILENT, f"silent, before: {report.words}", report.values)
        if now - report.arrival > GONE
        else NodeStatus(report.node, report.level, report.words, report.values)
        for report in heard.reports.values()
    )


def _seen(
    heard: HeardAircraft, state: Measurement, statuses: tuple[NodeStatus, ...], now: float
) -> Sight:
    report, figures = heard.reports.get(CONTROLLER), _fresh(heard.figures, now) or {}
    values = {} if report is None else report.values
    late = report is None or now - report.arrival > LATE_REPORT
    mode, reason = flown_mode(now - heard.plan.arrival, STALE, figures, {} if late else values)
    tracked = heard.tracked.arrival >= heard.sighting.arrival and heard.tracked.value is not None
    measured = heard.tracked.value if tracked else heard.sighting.value  # the last one stays
    plan, positions = _fresh(heard.plan, now), None
    if plan is not None and len(plan.positions):
        positions = plan.positions[plan.times >= state.stamp - plan.stamp]
    return heard_sight(
        state.stamp,
        state,
        _fresh(heard.airspeed, now),
        figures,
        _fresh(heard.orbit, now),
        (measured, _fresh(heard.truth, now)),
        values,
        plan=positions,
        mode=mode,
        reason=reason,
        cost=number(_fresh(heard.cost, now)),
        solve_time=number(_fresh(heard.solve_time, now)),
        latency=_latency(values),
        statuses=statuses,
    )


def _latency(values: Mapping[str, str]) -> float:
    try:
        return float(values.get("latency [s]", "nan"))
    except ValueError:
        return math.nan


def _fresh(message: NewestMessage[T], now: float) -> T | None:
    """What a message says, while others come."""
    return message.value if now - message.arrival <= STALE else None


class RosSteering(Steering):
    """Requests to the nodes of one aircraft.

    What is steered depends on who is there: with a real autopilot there is no simulator, with a
    tracker no simulated target, and only the launcher of a simulated flight kills controllers.

    Args:
        node: That asks (rclpy's Node), in an executor that is spun in a thread of its own.
        namespace: Of the aircraft, with or without slashes at its ends; empty for none.
    """

    def __init__(self, node: Any, namespace: str) -> None:
        self._requests = SteeringRequests(
            node,
            namespace,
            owners=(CONTROLLER, SIMULATOR, TARGET),
            switches=(ENGAGE, PAUSE),
            triggers=(RESET, *(service for service, _ in FAULTS.values())),
        )

    @property
    def nodes(self) -> frozenset[str]:  # type: ignore[override]  # only read
        """Who is there now."""
        return frozenset(
            owner for owner in (CONTROLLER, SIMULATOR, TARGET) if self._requests.offered(owner)
        )

    @property
    def faults(self) -> Mapping[str, str]:  # type: ignore[override]  # only read
        """Those that somebody offers now."""
        return {
            name: words
            for name, (service, words) in FAULTS.items()
            if self._requests.offered(service)
        }

    def parameters(self, node: str) -> Mapping[str, Any]:
        """See :meth:`Steering.parameters`; empty where the node does not answer."""
        try:
            return self._requests.parameters(node)
        except NoAnswerError:
            return {}

    def change(self, node: str, /, **values: Any) -> str:
        """See :meth:`Steering.change`."""
        return _answer(lambda: self._requests.change(node, values))

    def send_target(self, east: float, north: float) -> str:
        """See :meth:`Steering.send_target`.

        A topic does not answer: that the goal is accepted, or why it is not, the parameters tell,
        which a goal sets.
        """
        if not (math.isfinite(east) and math.isfinite(north)):
            return f"the target cannot go to ({east}, {north}): both must be finite"
        goal = self._requests.send_goal(east, north)
        if goal is None:
            return f"{TARGET} has not told where the target is"
        return self.change(TARGET, motion="stationary", position=goal)

    def pause(self, still: bool) -> str:
        """See :meth:`Steering.pause`."""
        return _answer(lambda: self._requests.call(PAUSE, data=still))

    def reset(self) -> str:
        """See :meth:`Steering.reset`."""
        return _answer(lambda: self._requests.call(RESET))

    def engage(self, on: bool) -> str:
        """See :meth:`Steering.engage`."""
        return _answer(lambda: self._requests.call(ENGAGE, data=on))

    def inject(self, fault: str) -> str:
        """See :meth:`Steering.inject`."""
        if fault not in self.faults:
            known = ", ".join(self.faults) or "none"
            return f"fault {fault!r} is not offered here; offered: {known}"
        return _answer(lambda: self._requests.call(FAULTS[fault][0]))


def _answer(request: Callable[[], str]) -> str:
    """Why a request was refused, or that nobody answered it."""
    try:
        return request()
    except NoAnswerError as error:
        return str(error)


class LiveFlight(FlownFlight):
    """One aircraft, as it is heard.

    Args:
        watcher: That listens to it.
        namespace: Of the aircraft, absolute.
    """

    def __init__(self, watcher: FlightWatcher, namespace: str) -> None:
        super().__init__(PAST_SPAN)
        self.name = namespace.strip("/").replace("/", ".") or ROOT
        self._heard, self._parameters = watcher.aircraft[namespace], watcher.parameters[namespace]
        self.steering = RosSteering(watcher, namespace)
        self._sight: Sight | None = None
        self._lock = threading.Lock()

    @property
    def sight(self) -> Sight | None:
        """What there is to see now; None before the first state."""
        with self._lock:
            now = time.monotonic()
            statuses = node_statuses(self._heard, now)
            self._sight = live_sight(self._heard, self._sight, statuses, now)
            if self._sight is not None:  # kept a few times a second
                self.keep(self._sight)
            return self._sight

    @property
    def seen(self) -> bool:
        """Whether there was something to see when somebody looked last."""
        return self._sight is not None

    @property
    def tracking(self) -> TrackingParameters | None:  # type: ignore[override]  # only read
        """What its controller flies by; None before it has answered."""
        return self._parameters.value


class LiveSource(FlightSource):
    """Every aircraft of a ROS domain, as it appears.

    Args:
        domain: ROS domain; that of the environment by default.

    Raises:
        DomainValueError: The environment names a domain that is none.
    """

    def __init__(self, domain: int | None = None) -> None:
        self._domain = (exported_domain() or 0) if domain is None else domain
        self._spun = BackgroundNode(FlightWatcher, self._domain)
        self._flights: dict[str, LiveFlight] = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="past of flights", daemon=True)
        self._keeper.start()

    @property
    def words(self) -> str:
        """That nothing flies yet; empty once something does."""
        if any(flight.seen for flight in self.flights()):
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
