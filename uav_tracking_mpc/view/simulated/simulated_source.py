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

"""A flight that is simulated in this process while it is watched and steered."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import Witness
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.plants import Plant
from uav_tracking_mpc.view.play_clock import PlayClock
from uav_tracking_mpc.view.sight import NodeStatus, Sight
from uav_tracking_mpc.view.simulated.interrupted_loop import InterruptedLoop
from uav_tracking_mpc.view.simulated.request_queue import RequestQueue
from uav_tracking_mpc.view.simulated.simulated_sight import SimulatedSights
from uav_tracking_mpc.view.simulated.simulated_status import ERROR
from uav_tracking_mpc.view.simulated.simulated_steering import SimulatedSteering
from uav_tracking_mpc.view.steering import SIMULATOR
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

logger = logging.getLogger(__name__)

PAST_PERIOD = 0.2  # s between the sights that are kept
PAST_SPAN = 600.0  # s of them
MOST_BEHIND = 0.25  # s of wall time by which the flight may be late; more is not caught up with
STANDING = 0.1  # s of wall time between looks at a flight that stands still


class SimulatedFlight(WatchedFlight):
    """Flies a loop by a clock; what is asked of it is done between two ticks.

    Args:
        configuration: What to fly, and how fast at first.
        clock: By which it is flown, at ``mission.speed`` times its wall time.
        witness: Called after each tick, as by ``simulate``.

    Attributes:
        loop: That is flown.
        clock: As above.
        requests: What is asked for by other threads.
        steering: Of this flight.
        name: Of the configuration.

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The plant cannot fly the mission.
    """

    steering: SimulatedSteering

    def __init__(
        self, configuration: Configuration, clock: PlayClock, witness: Witness | None = None
    ) -> None:
        speed = configuration.mission.speed
        simulator = changed(configuration.simulator, {"speed": speed})
        self.name, self.clock, self.requests = configuration.name, clock, RequestQueue()
        self.loop = InterruptedLoop(replace(configuration, simulator=simulator))
        self.steering = SimulatedSteering(self.loop, clock, self.requests)
        self._sights = SimulatedSights(self.loop)
        self._witness = witness
        self._sight: Sight | None = None
        self._failed: Plant | None = None  # the plant that cannot fly on
        self._past: deque[Sight] = deque(maxlen=round(PAST_SPAN / PAST_PERIOD))
        self._lock = threading.Lock()  # of what is past
        clock.play(speed)

    @property
    def sight(self) -> Sight | None:
        """See :meth:`WatchedFlight.sight`."""
        return self._sight

    @property
    def tracking(self) -> TrackingParameters:
        """See :meth:`WatchedFlight.tracking`."""
        return self.loop.controller.parameters

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`."""
        with self._lock:
            begin = self._past[-1].time - span if self._past else 0.0
            return [sight for sight in self._past if sight.time >= begin]

    def advance(self) -> float:
        """Do what was asked for, and fly one tick if the clock has come to it.

        A machine that is too slow lets the clock wait, so that a flight is as fast as it can be.

        Returns:
            Wall time until there may be something to do in [s].
        """
        self.requests.serve()
        clock, loop = self.clock, self.loop
        if not clock.playing or self._failed is loop.plant:
            return STANDING
        late = (clock.time - loop.time) / clock.rate
        if late < 0.0:
            return -late
        if late > MOST_BEHIND:
            clock.seek(loop.time)
        try:
            tick = loop.tick()
        except Exception as error:  # whatever a user's plant raises, the page goes on
            logger.warning(f"the plant failed, reset it to fly on: {error}")
            self._fail(str(error))
        else:
            self._show(self._sights.at(tick))
            if self._witness is not None:
                self._witness(tick.time, tick.measured, tick.command)
        return 0.0

    def _fail(self, words: str) -> None:
        self._failed = self.loop.plant
        if self._sight is not None:
            others = [each for each in self._sight.statuses if each.node != SIMULATOR]
            failed = NodeStatus(SIMULATOR, ERROR, f"the plant failed: {words}")
            self._sight = replace(self._sight, statuses=(failed, *others))

    def _show(self, sight: Sight) -> None:
        self._sight = sight
        if not self._past or sight.time >= self._past[-1].time + PAST_PERIOD - 1e-9:
            with self._lock:  # what is far back is not as large as what is now
                self._past.append(replace(sight, plan=None, statuses=()))


class SimulatedSource(FlightSource):
    """One flight, flown by a thread of its own until it is closed.

    Args:
        configuration: What to fly, and how fast at first.
        witness: Called after each tick, as by ``simulate``.
        now: Steady wall time in [s].

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The plant cannot fly the mission.
    """

    def __init__(
        self,
        configuration: Configuration,
        witness: Witness | None = None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flight = SimulatedFlight(configuration, PlayClock(0.0, math.inf, now), witness)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._fly, name="simulation", daemon=True)
        self._thread.start()

    def flights(self) -> Sequence[SimulatedFlight]:
        """The one."""
        return [self._flight]

    def close(self) -> None:
        """End the flight."""
        self._closed.set()
        self._thread.join()
        self._flight.requests.close()

    def log(self) -> FlightLog:
        """Record of all that was flown, once it is closed.

        Raises:
            SimulationError: Nothing was flown.
        """
        loop = self._flight.loop
        return replace(loop.log(loop.time), speed=loop.plant.parameters.speed)

    def _fly(self) -> None:
        wait = 0.0
        while not self._closed.is_set():
            self._flight.requests.serve(wait)
            wait = self._flight.advance()
