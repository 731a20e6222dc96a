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

"""Steering of a simulation in this process: requests, faults, the classical laws beside it."""

from __future__ import annotations

import concurrent.futures
import contextlib
import logging
import math
import queue
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.parameters.registry import names_of
from uav_tracking_mpc.parameters.specification import ParameterError, changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop, Sightings
from uav_tracking_mpc.simulation.plants import AIR, SimulationError
from uav_tracking_mpc.simulation.steered_target import STATIONARY, TargetSensor
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SIMULATOR,
    TARGET,
    PlayClock,
    RivalSight,
    Steering,
)

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

        Raises:
            ParameterError: It was killed.
        """
        if self.killed:
            raise ParameterError(KILLED)
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


PATIENCE = 10.0  # s of wall time, in which a request is answered or taken back
OVER = "the simulation has ended"

Request = Callable[[], None]
Answer = concurrent.futures.Future[str]


class RequestQueue:
    """A queue of requests, each answered with why it was refused, or nothing.

    Args:
        done: Called after each request that was not refused, before it is answered.
    """

    def __init__(self, done: Callable[[], None] = lambda: None) -> None:
        self._done = done
        self._waiting: queue.SimpleQueue[tuple[Request, Answer]] = queue.SimpleQueue()
        self._closed = False

    def ask(self, request: Request) -> str:
        """Have something done, and wait for it.

        Args:
            request: Called by the thread that serves; raises ParameterError or SimulationError
                with the reason where it refuses.

        Returns:
            Why it was refused; empty where it was done.
        """
        answer: Answer = concurrent.futures.Future()
        self._waiting.put((request, answer))
        if self._closed:
            self.serve()
        try:
            return answer.result(PATIENCE)
        except concurrent.futures.TimeoutError:
            if answer.cancel():
                return f"the simulation has not answered within {PATIENCE:g} s"
            return answer.result()

    def serve(self, wait: float = 0.0) -> None:
        """Carry out what has been asked for, in order.

        Args:
            wait: How long to wait for the first request in [s].
        """
        try:
            self._answer(*self._waiting.get(timeout=max(wait, 0.0)))
            while True:
                self._answer(*self._waiting.get_nowait())
        except queue.Empty:
            return

    def close(self) -> None:
        """Refuse what is still asked for, and all that is asked from now on."""
        self._closed = True
        self.serve()

    def _answer(self, request: Request, answer: Answer) -> None:
        if not answer.set_running_or_notify_cancel():
            return
        if self._closed:
            answer.set_result(OVER)
            return
        try:
            request()
            self._done()
            answer.set_result("")
        except (ParameterError, SimulationError) as refusal:
            answer.set_result(str(refusal))
        except Exception as error:  # whatever happened, the thread that serves flies on
            answer.set_exception(error)


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

    comparable = True

    def __init__(self, loop: InterruptedLoop, clock: PlayClock, requests: RequestQueue) -> None:
        self._loop, self._clock, self._requests = loop, clock, requests
        self.rivals = Rivals(loop)

    def compare(self, on: bool) -> str:
        """See :meth:`Steering.compare`."""
        return self._requests.ask(lambda: self.rivals.fly(on))

    def parameters(self, node: str) -> Mapping[str, Any]:
        """See :meth:`Steering.parameters`."""
        loop = self._loop
        present: dict[str, Any] = {
            CONTROLLER: loop.controller.parameters,
            SIMULATOR: loop.plant.parameters,
            TARGET: loop.target.parameters,
        }
        values = asdict(present[node])
        # What flies is the mission's to say.
        return {**values, "plant": loop.plant.name} if node == SIMULATOR else values

    def change(self, node: str, /, **values: Any) -> str:
        """See :meth:`Steering.change`."""
        changes = {
            CONTROLLER: self._change_controller,
            SIMULATOR: self._change_simulator,
            TARGET: self._change_target,
        }
        return self._requests.ask(lambda: changes[node](values))

    def send_target(self, east: float, north: float) -> str:
        """See :meth:`Steering.send_target`."""

        def send() -> None:
            target, now = self._loop.target, self._loop.time
            goal = (east, north, float(target.position(now)[2]))
            target.check(changed(target.parameters, {"motion": STATIONARY, "position": goal}))
            target.go_to(now, goal)

        return self._requests.ask(send)

    def pause(self, still: bool) -> str:
        """See :meth:`Steering.pause`."""
        return self._requests.ask(self._clock.pause if still else self._clock.play)

    def reset(self) -> str:
        """See :meth:`Steering.reset`."""

        def reset() -> None:
            self._loop.reset()
            self._clock.seek(self._loop.time)

        return self._requests.ask(reset)

    def engage(self, on: bool) -> str:
        """See :meth:`Steering.engage`."""
        return self._requests.ask(lambda: self._loop.engage(on))

    def inject(self, fault: str) -> str:
        """See :meth:`Steering.inject`."""
        return self._requests.ask(lambda: self._loop.inject(fault))

    def _change_controller(self, values: Mapping[str, Any]) -> None:
        if self._loop.killed:
            raise ParameterError(KILLED)
        self._loop.controller.change(**values)

    def _change_simulator(self, values: Mapping[str, Any]) -> None:
        plant, clock = self._loop.plant, self._clock
        plant.change(changed(plant.parameters, values))
        if (speed := plant.parameters.speed) != clock.rate:
            playing = clock.playing
            clock.play(speed)
            if not playing:
                clock.pause()

    def _change_target(self, values: Mapping[str, Any]) -> None:
        target = self._loop.target
        parameters = changed(target.parameters, values)
        target.change(self._loop.time, parameters)
        self._loop.sensor.change(parameters)


logger = logging.getLogger(__name__)

ORBIT = ("range", "altitude", "airspeed", "direction")  # parameters of what is asked for


def law_names() -> list[str]:
    """The laws that are flown beside."""
    return names_of("uav_tracking_mpc.laws")


class Rival(ClosedLoop):
    """A law that begins where an aircraft is, and goes on with its target and its air.

    Args:
        law: Name of the law.
        leader: What is flown beside; its target is this one's, its wind and orbit are followed.

    Raises:
        ParameterError: The law cannot fly by these parameters.
        SimulationError: The plant cannot start there.
    """

    def __init__(self, law: str, leader: ClosedLoop) -> None:
        self.law, self._leader = law, leader
        super().__init__(_from_here(law, leader))
        self.target = leader.target
        self.sensor = TargetSensor(self.configuration.target, leader.target)
        self._ticks = leader._ticks
        self._began = self.time

    def follow(self) -> RivalSight:
        """Fly the tick that the leader has flown; what there is to see of it then.

        Raises:
            ParameterError: What the leader flies by now cannot be flown by this law.
            SimulationError: The plant cannot fly on.
        """
        leader, plant = self._leader, self.plant
        air = {name: getattr(leader.plant.parameters, name) for name in AIR}
        if any(getattr(plant.parameters, name) != value for name, value in air.items()):
            plant.change(changed(plant.parameters, air))
        mine, orbit = self.controller.parameters, _orbit(leader)
        if any(getattr(mine, name) != value for name, value in orbit.items()):
            self.controller.change(**orbit)
        tick = self.tick()
        truth = tick.truth
        away = float(np.linalg.norm(truth.position - self.target.position(tick.time)))
        return RivalSight(
            self.law,
            truth.position,
            truth.heading,
            truth.path_angle,
            0.0 if truth.bank is None else truth.bank,
            away - orbit["range"],
        )


def _orbit(leader: ClosedLoop) -> dict[str, Any]:
    """What is asked for, in the direction that was chosen."""
    asked, flown = leader.controller.parameters, leader.controller.orbit
    return {name: getattr(asked, name) for name in ORBIT} | {"direction": flown.direction}


def _from_here(law: str, leader: ClosedLoop) -> Configuration:
    """What is flown beside, from the leader's present state."""
    truth, plant = leader.plant.truth, leader.plant.parameters
    speed = plant.initial_speed if truth.airspeed is None else truth.airspeed
    start = {
        "initial_position": truth.position.tolist(),
        "initial_heading": float(np.angle(np.exp(1j * truth.heading))),
        "initial_path_angle": truth.path_angle,
        "initial_speed": min(max(speed, plant.speed_min), plant.speed_max),
        **{name: getattr(plant, name) for name in AIR},
    }
    configuration = leader.configuration.changed("uav_simulator", start)
    return configuration.changed("nmpc_controller", {"law": law, **_orbit(leader)})


class Rivals:
    """All laws beside a flight, as long as they are asked for.

    Args:
        leader: What is flown.
    """

    def __init__(self, leader: ClosedLoop) -> None:
        self._leader, self._plant = leader, leader.plant
        self._wanted = False
        self._flying: list[Rival] = []

    def fly(self, wanted: bool) -> None:
        """Begin where the aircraft is, or end.

        Args:
            wanted: Whether they are to fly.
        """
        self._wanted, self._plant = wanted, self._leader.plant
        self._flying = []
        for law in law_names() if wanted else ():
            try:
                self._flying.append(Rival(law, self._leader))
            except Exception as error:  # whatever a user's plant raises, the others fly
                logger.warning("%s is not flown beside: %s", law, error)

    def follow(self) -> tuple[RivalSight, ...]:
        """Fly on by the tick that the leader has flown; one that cannot go on is left behind."""
        if self._wanted and self._plant is not self._leader.plant:  # it was put back to its start
            self.fly(True)
        seen = []
        for rival in list(self._flying):
            try:
                seen.append(rival.follow())
            except Exception as error:  # as above
                logger.warning("%s is left behind: %s", rival.law, error)
                self._flying.remove(rival)
        return tuple(seen)
