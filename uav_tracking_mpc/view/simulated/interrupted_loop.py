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

"""A closed loop in which messages get lost and the controller is killed, for some seconds."""

from __future__ import annotations

import contextlib
import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop, Sightings

TARGET_LOST, STATE_LOST, CONTROLLER_KILLED = "target lost", "state lost", "controller killed"
DURATIONS = {TARGET_LOST: 15.0, STATE_LOST: 15.0, CONTROLLER_KILLED: 5.0}  # s of simulated time
KILLED = "the controller was killed"
LOST = "vehicle state is lost: nothing usable comes"
DISENGAGED = "disengaged"


class InterruptedLoop(ClosedLoop):
    """What becomes of the controller is what becomes of its node.

    A fault ends by itself. A killed controller is followed by a new one with the parameters of the
    start. One that is disengaged goes on to see aircraft and target.

    Args:
        configuration: What to fly.

    Attributes:
        sighting: The newest position of the target that reached the controller, shape (3,), in
            [m]; None before the first.
        commanded: Whether a command has ever been sent.
    """

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self.sighting: NDArray[np.float64] | None = None
        self.commanded = False
        self._engaged = True
        self._until: dict[str, float] = {}  # end of each fault that lasts [s]

    @property
    def killed(self) -> bool:
        """Whether there is no controller now."""
        return CONTROLLER_KILLED in self._until

    @property
    def mode(self) -> FallbackMode | None:
        """What the controller commands; None before the first command."""
        return self.controller.modes.mode if self.commanded else None

    def inject(self, fault: str) -> None:
        """Let a fault happen from now on.

        Args:
            fault: One of ``DURATIONS``.

        Raises:
            ParameterError: There is no such fault.
        """
        if fault not in DURATIONS:
            raise ParameterError(f"fault is {fault!r}, must be one of {', '.join(DURATIONS)}")
        self._until[fault] = self.time + DURATIONS[fault]
        if fault == CONTROLLER_KILLED:
            self.controller.fall_silent(KILLED)  # nobody asks it any more

    def engage(self, on: bool) -> None:
        """Let the controller command, or keep it silent.

        Args:
            on: Whether it is to command.
        """
        self._engaged = on
        if not on:
            self.controller.reset()
            self.controller.fall_silent(DISENGAGED)
        self.controller.engage(on)

    def answer(self, sightings: Sightings, measured: Measurement, now: float) -> Command | None:
        """See :meth:`ClosedLoop.answer`."""
        self._end_faults(now)
        if self.killed:
            return None
        if TARGET_LOST not in self._until:
            for stamp, position in sightings:
                self.sighting = position
                with contextlib.suppress(MeasurementError):  # ahead of a state that got lost
                    self.controller.see_target(stamp, position)
        command = self._step(measured, now)
        self.commanded = self.commanded or command is not None
        return command

    def _step(self, measured: Measurement, now: float) -> Command | None:
        controller = self.controller
        if STATE_LOST in self._until:
            newest = -math.inf if controller.state_time is None else controller.state_time
            if now - newest > controller.parameters.state_timeout:
                controller.fall_silent(LOST)
            return None
        if not self._engaged:
            controller.see_state(measured)
            controller.fall_silent(DISENGAGED)
            return None
        return controller.step(measured, now)

    def _end_faults(self, now: float) -> None:
        over = [fault for fault, end in self._until.items() if now >= end]
        for fault in over:
            del self._until[fault]
        if CONTROLLER_KILLED in over:
            self.restart_controller()
            self._engaged = True
