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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.commanded_path import CommandPaths
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.messages.diagnostic_values import (
    AXES,
    ERROR,
    OK,
    controller_status,
    target_words,
    vehicle_status,
)
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.closed_loop import Tick, Witness
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.plants import Plant
from uav_tracking_mpc.view.simulated_steering import (
    KILLED,
    InterruptedLoop,
    RequestQueue,
    SimulatedSteering,
)
from uav_tracking_mpc.view.snapshot import sight_of
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SILENT,
    SIMULATOR,
    TARGET,
    FlightSource,
    FlownFlight,
    NodeStatus,
    PlayClock,
    Sight,
    TargetSight,
)


def statuses(loop: InterruptedLoop) -> tuple[NodeStatus, ...]:
    """What controller, plant and target say of themselves, as their nodes would.

    Args:
        loop: That is flown.
    """
    target = NodeStatus(TARGET, OK, target_words(loop.target, loop.time))
    return _controller(loop), _simulator(loop), target


def _controller(loop: InterruptedLoop) -> NodeStatus:
    if loop.killed:
        return NodeStatus(CONTROLLER, SILENT, KILLED)
    controller = loop.controller
    mode, reason, counts = controller.modes.mode, controller.modes.reason, controller.modes.counts
    formulation, health = controller.formulation, controller.navigator.air_estimate.health
    values = {
        "mode changes": f"{controller.modes.changes}",
        **{f"mode {each.value}": f"{count}" for each, count in counts.items()},
        "solver": "none" if formulation is None else formulation.solver.name,
        **_axes("drift", controller.drift),
        "target noise [m]": f"{controller.navigator.target.noise:.3g}",
        "target positions rejected": f"{controller.navigator.target.rejected}",
        **health.values(),
    }
    level, words, why = controller_status(mode, reason, loop.commanded)
    return NodeStatus(CONTROLLER, level, f"{words}: {why}" if why else words, values)


def _simulator(loop: InterruptedLoop) -> NodeStatus:
    plan, speed = loop.plant.plan, loop.plant.parameters.speed
    values = {
        **_axes("wind", loop.plant.wind),
        "speed": f"{speed:g}",
        "failsafe": f"{plan.failsafes}",
    }
    return NodeStatus(SIMULATOR, *vehicle_status(plan), values)


def _axes(name: str, vector: NDArray[np.float64]) -> dict[str, str]:
    return {
        f"{name} {axis} [m/s]": f"{value:.2f}" for axis, value in zip(AXES, vector, strict=True)
    }


FORECAST = (0.0, 2.5, 5.0, 7.5, 10.0)  # s from now on, for which the target is forecast
FORECAST_PERIOD = 0.5  # s between two forecasts


class SimulatedSights:
    """Sights of a loop, tick by tick.

    Aircraft and errors are true; the target, its uncertainty and the wind are as the controller
    estimates them, beside the truth of the target.

    Args:
        loop: That is flown.
    """

    def __init__(self, loop: InterruptedLoop) -> None:
        self._loop, self._paths = loop, CommandPaths()
        self._command: Command | None = None
        self._path = np.zeros((0, 3))  # positions at the ends of the stages of its plan
        self._forecast, self._forecast_at = np.zeros((0, 4)), -math.inf

    def at(self, tick: Tick) -> Sight:
        """What there is to see at the time of a tick.

        Args:
            tick: The latest one.
        """
        loop, truth, command = self._loop, tick.truth, tick.command
        if command is not None:
            path = self._paths.path(loop.controller, tick.measured, command)
            self._command, self._path = command, path.states[1:, :3]
        mode, target = loop.mode, self._target(tick.time)
        silent = mode in (None, FallbackMode.SILENCE)
        solution = None if self._command is None or silent else self._command.solution
        return sight_of(
            tick.time,
            truth,
            truth.airspeed,
            target,
            loop.controller.orbit,
            wind=loop.plant.wind if silent else loop.controller.navigator.wind,
            flown=None if self._command is None or silent else self._command.flown_orbit,
            plan=self._plan(tick),
            mode=mode,
            reason=loop.controller.modes.reason,
            errors={} if target is None else self._errors(truth, tick.time),
            cost=math.nan if solution is None else solution.cost,
            solve_time=math.nan if solution is None else solution.solve_time,
            statuses=statuses(loop),
        )

    def _target(self, now: float) -> TargetSight | None:
        loop, known = self._loop, self._loop.controller.navigator.target
        truth = loop.target.position(now)
        if not loop.killed and known.time is not None:
            position, velocity, _ = known.motion(now)
            deviation = known.track.position_std(now)
            if not 0.0 <= now - self._forecast_at < FORECAST_PERIOD:
                ahead = [now + later for later in FORECAST]
                rows = [[*known.motion(time)[0], known.track.position_std(time)] for time in ahead]
                self._forecast = np.array(rows)
                self._forecast_at = now
            return TargetSight(position, velocity, deviation, loop.sighting, truth, self._forecast)
        if loop.sighting is None:
            return None
        return TargetSight(loop.sighting, measured=loop.sighting, truth=truth)

    def _plan(self, tick: Tick) -> NDArray[np.float64] | None:
        """Where the aircraft goes while it flies the newest plan; what is flown of it is left out.

        Returns:
            Positions in [m], shape (n, 3); None where no plan is flown.
        """
        command = self._command
        if command is None or self._loop.plant.plan.holding:
            return None
        ends = command.stamp + command.step * np.arange(1, len(self._path) + 1)
        return np.vstack([tick.truth.position, self._path[ends > tick.time]])

    def _errors(self, truth: Measurement, now: float) -> Mapping[str, float]:
        """Of the true state about the true target."""
        vehicle = truth.state(math.nan if truth.airspeed is None else truth.airspeed)
        target = self._loop.target
        drift = truth.ground_velocity - velocity(vehicle) - target.velocity(now)
        still = np.zeros(3)
        situation = Situation(vehicle, target.position(now), drift, still, still)
        errors = situation.tracking_error(self._loop.controller.orbit).tolist()
        return dict(zip(ERRORS, errors, strict=True))


logger = logging.getLogger(__name__)

PAST_SPAN = 600.0  # s
MOST_BEHIND = 0.25  # s of wall time by which the flight may be late; more is not caught up with
STANDING = 0.1  # s of wall time between looks at a flight that stands still


class SimulatedFlight(FlownFlight):
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
        trouble: Why there is nothing to see, in words.

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The plant cannot fly the mission.
    """

    steering: SimulatedSteering
    sight: Sight | None = None
    trouble = ""

    def __init__(
        self, configuration: Configuration, clock: PlayClock, witness: Witness | None = None
    ) -> None:
        super().__init__(PAST_SPAN)
        speed = configuration.mission.speed
        simulator = changed(configuration.simulator, {"speed": speed})
        self.name, self.clock = configuration.name, clock
        self.requests = RequestQueue(self._look_again)
        self.loop = InterruptedLoop(replace(configuration, simulator=simulator))
        self.steering = SimulatedSteering(self.loop, clock, self.requests)
        self._sights = SimulatedSights(self.loop)
        self._witness = witness
        self._failed: Plant | None = None  # the plant that cannot fly on
        clock.play(speed)

    @property
    def tracking(self) -> TrackingParameters:  # type: ignore[override]  # only read
        """Parameters of the controller."""
        return self.loop.controller.parameters

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
            sight = self._sights.at(tick)
            self.sight = replace(sight, rivals=self.steering.rivals.follow())
            self.keep(self.sight)
            if self._witness is not None:
                self._witness(tick.time, tick.measured, tick.command)
        except Exception as error:  # whatever a user's plant or motion raises, the page goes on
            logger.warning(f"the flight cannot go on, reset it to fly on: {error}")
            self._fail(str(error))
        return 0.0

    def _look_again(self) -> None:
        """Show what a request has changed while no tick shows it."""
        loop = self.loop
        if self.sight is None or self.clock.playing or self._failed is loop.plant:
            return
        truth = loop.plant.truth
        sight = self._sights.at(Tick(loop.time, truth, truth, None))
        self.sight = replace(sight, rivals=self.sight.rivals)

    def _fail(self, words: str) -> None:
        self._failed, words = self.loop.plant, f"the plant failed: {words}"
        if self.sight is None:
            self.trouble = words
        else:
            others = [each for each in self.sight.statuses if each.node != SIMULATOR]
            failed = NodeStatus(SIMULATOR, ERROR, words)
            self.sight = replace(self.sight, statuses=(failed, *others))


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

    @property
    def words(self) -> str:
        """Why there is nothing to see; empty once there was something."""
        return "" if self._flight.sight else self._flight.trouble

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
            wait = min(self._flight.advance(), STANDING)  # soon enough to be closed
