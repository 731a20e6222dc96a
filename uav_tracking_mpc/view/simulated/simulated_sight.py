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

"""What there is to see of an aircraft that is simulated in this process."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.commanded_path import CommandPaths
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit, orbit_about
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.simulation.closed_loop import Tick
from uav_tracking_mpc.view.sight import Sight, TargetSight
from uav_tracking_mpc.view.simulated.interrupted_loop import InterruptedLoop
from uav_tracking_mpc.view.simulated.simulated_status import statuses

ERRORS = ("range_error", "bearing_error", "altitude_error", "pitch_error", "speed_error")


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
        airspeed = math.nan if truth.airspeed is None else truth.airspeed
        return Sight(
            time=tick.time,
            position=truth.position,
            heading=truth.heading,
            path_angle=truth.path_angle,
            bank=bank_from_turn_rate(truth.turn_rate, airspeed),
            airspeed=airspeed,
            ground_velocity=truth.ground_velocity,
            wind=loop.plant.wind if silent else loop.controller.navigator.wind,
            target=target,
            wanted=self._wanted(target),
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
            estimate = known.predict(now)
            return TargetSight(
                estimate.position, estimate.velocity, estimate.position_std, loop.sighting, truth
            )
        if loop.sighting is None:
            return None
        return TargetSight(loop.sighting, measured=loop.sighting, truth=truth)

    def _wanted(self, target: TargetSight | None) -> FlownOrbit | None:
        if target is None:
            return None
        moving = np.zeros(3) if target.velocity is None else target.velocity
        return orbit_about(target.position, moving, self._loop.controller.orbit)

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
