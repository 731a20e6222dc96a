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

"""Steering of a simulation in this process, through the calls that a user of the library has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.simulation.steered_target import STATIONARY
from uav_tracking_mpc.view.play_clock import PlayClock
from uav_tracking_mpc.view.simulated.interrupted_loop import (
    CONTROLLER_KILLED,
    DURATIONS,
    KILLED,
    STATE_LOST,
    TARGET_LOST,
    InterruptedLoop,
)
from uav_tracking_mpc.view.simulated.request_queue import RequestQueue
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR, TARGET, Steering

FAULTS = {
    TARGET_LOST: "nothing that is measured of the target reaches the controller for {:g} s",
    STATE_LOST: "no state of the aircraft reaches the controller for {:g} s",
    CONTROLLER_KILLED: "the controller is gone for {:g} s, then a new one starts as this one did",
}


class SimulatedSteering(Steering):
    """Requests, which the thread of the loop carries out between two ticks.

    Args:
        loop: That is flown.
        clock: By which it is flown.
        requests: Served by the thread of the loop.
    """

    nodes = frozenset({CONTROLLER, SIMULATOR, TARGET})
    faults: Mapping[str, str] = {
        name: words.format(DURATIONS[name]) for name, words in FAULTS.items()
    }

    def __init__(self, loop: InterruptedLoop, clock: PlayClock, requests: RequestQueue) -> None:
        self._loop, self._clock, self._requests = loop, clock, requests

    def parameters(self, node: str) -> Mapping[str, Any]:
        """See :meth:`Steering.parameters`."""
        loop = self._loop
        present: dict[str, Any] = {
            CONTROLLER: loop.controller.parameters,
            SIMULATOR: loop.plant.parameters,
            TARGET: loop.target.parameters,
        }
        return asdict(present[node])

    def change(self, node: str, **values: Any) -> str:
        """See :meth:`Steering.change`."""
        changes = {
            CONTROLLER: self._change_controller,
            SIMULATOR: self._change_simulator,
            TARGET: self._change_target,
        }
        return self._requests.ask(lambda: changes[node](values))

    def send_target(self, east: float, north: float) -> str:
        """See :meth:`Steering.send_target`."""

        def send() -> str:
            target, now = self._loop.target, self._loop.time
            goal = (east, north, float(target.position(now)[2]))
            values = {"motion": STATIONARY, "position": goal}
            target.check(changed(target.parameters, values))
            target.go_to(now, goal)
            return ""

        return self._requests.ask(send)

    def pause(self, still: bool) -> str:
        """See :meth:`Steering.pause`."""

        def pause() -> str:
            if still:
                self._clock.pause()
            else:
                self._clock.play()
            return ""

        return self._requests.ask(pause)

    def reset(self) -> str:
        """See :meth:`Steering.reset`."""

        def reset() -> str:
            self._loop.reset()
            self._clock.seek(self._loop.time)
            return ""

        return self._requests.ask(reset)

    def engage(self, on: bool) -> str:
        """See :meth:`Steering.engage`."""

        def engage() -> str:
            if self._loop.killed:
                return KILLED
            self._loop.engage(on)
            return ""

        return self._requests.ask(engage)

    def inject(self, fault: str) -> str:
        """See :meth:`Steering.inject`."""

        def inject() -> str:
            self._loop.inject(fault)
            return ""

        return self._requests.ask(inject)

    def _change_controller(self, values: Mapping[str, Any]) -> str:
        if self._loop.killed:
            return KILLED
        self._loop.controller.change(**values)
        return ""

    def _change_simulator(self, values: Mapping[str, Any]) -> str:
        plant = self._loop.plant
        plant.change(changed(plant.parameters, values))
        clock, speed = self._clock, plant.parameters.speed
        if speed != clock.rate:
            playing = clock.playing
            clock.play(speed)
            if not playing:
                clock.pause()
        return ""

    def _change_target(self, values: Mapping[str, Any]) -> str:
        target = self._loop.target
        parameters = changed(target.parameters, values)
        target.change(self._loop.time, parameters)
        self._loop.sensor.change(parameters)
        return ""
