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

"""The closed loop: a plant, a target and the controller that flies, in turn, deterministic."""

from __future__ import annotations

import math
from array import array
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.sensor_health import USED
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import Configuration, Sections, override
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog, FlownMode, SensorNews
from uav_tracking_mpc.simulation.plants import Plant, SimulationError, plant_of
from uav_tracking_mpc.simulation.steered_target import SteeredTarget, TargetSensor

Progress = Callable[[float], None]
Witness = Callable[[float, Measurement, Command | None], None]
Disturbance = Callable[[float], NDArray[np.float64]]
Sightings = Sequence[tuple[float, NDArray[np.float64]]]


SAMPLE = 18  # numbers that are recorded at each time


class Tick(NamedTuple):
    """What happened at one time of a loop.

    Attributes:
        time: In [s].
        truth: State of the aircraft, as ideal sensors would give it.
        measured: What the sensors give.
        command: What the controller answers; None for nothing.
    """

    time: float
    truth: Measurement
    measured: Measurement
    command: Command | None


class _Recorder:
    """Collects a flight sample by sample, as bare numbers: a flight may last for hours."""

    def __init__(self) -> None:
        # Rows of time, vehicle, velocity over ground, turn rate, the target's place and velocity,
        # bank;
        # and of stamp, inputs, cost, time of the solve, whether it is what was asked for.
        self.samples, self.commands = array("d"), array("d")
        self.flown_modes: list[FlownMode] = []
        self.modes: Counter[FallbackMode] = Counter()
        self.failures = 0
        self.softened = 1.0
        self.sensors: list[SensorNews] = []
        self._health: dict[str, str] = {}
        self._asked: TrackingParameters | None = None
        self._steered = False
        self._orbits: list[tuple[float, Orbit]] = []

    def sample(self, now: float, truth: Measurement, target: SteeredTarget) -> None:
        airspeed = np.nan if truth.airspeed is None else truth.airspeed
        self.samples.extend([now, *truth.state(airspeed).tolist(), *truth.ground_velocity.tolist()])
        place, velocity = target.position(now).tolist(), target.velocity(now).tolist()
        bank = np.nan if truth.bank is None else truth.bank
        self.samples.extend([truth.turn_rate, *place, *velocity, bank])

    def health(self, now: float, states: Mapping[str, str]) -> None:
        """Note which sensors are used otherwise than before."""
        for sensor, state in states.items():
            if state != self._health.get(sensor, USED):
                self.sensors.append(SensorNews(now, sensor, state))
        self._health = dict(states)

    def mode(self, now: float, mode: FallbackMode, reason: str) -> None:
        """Note the mode where it is another, with the reason that it begins with."""
        if not self.flown_modes or self.flown_modes[-1].mode is not mode:
            self.flown_modes.append(FlownMode(now, mode, reason))

    def command(self, command: Command, asked: TrackingParameters) -> None:
        solution, mode = command.solution, command.mode
        solved = [np.nan] * 2 if solution is None else [solution.cost, solution.solve_time]
        inputs = command.inputs[0].tolist()
        self.commands.extend([command.stamp, *inputs, *solved, mode.nominal])
        self.modes[mode] += 1
        self.failures += solution is not None and not solution.converged
        self._steered = self._steered or asked is not (self._asked or asked)
        self._asked = asked
        if not self._orbits or self._orbits[-1][1] != command.orbit:
            self._orbits.append((command.stamp, command.orbit))

    @property
    def orbit(self) -> Orbit:
        """The last reference."""
        return self._orbits[-1][1]

    @property
    def orbits(self) -> tuple[tuple[float, Orbit], ...]:
        """References from their times on; none where nobody asked for another one."""
        return tuple(self._orbits) if self._steered else ()


class ClosedLoop:
    """A mission, flown tick by tick.

    Plant, sensors and target run at the rates at which the nodes run. The controller takes no time
    to answer, and its solves have no budget of wall time: a flight depends on nothing but its
    configuration.
    Between two ticks everything can be changed as in flight: ``controller.change``,
    ``plant.change``, ``target.go_to`` at :attr:`time`, and so on.

    Args:
        configuration: What to fly.
        formulation: That another flight may have used, of a problem that differs in nothing fixed;
            it is set to these parameters. Made by default.
        disturbance: Added to commands on their way to the plant, of which the controller does not
            know: called with their time in [s], answers (u_psi, u_chi, u_v), shape (3,).

    Attributes:
        configuration: As above.
        plant: What is flown.
        target: What is circled.
        sensor: How the target is measured.
        controller: What flies.
        rate: Ticks a second in [Hz].

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The plant cannot fly the mission.
    """

    def __init__(
        self,
        configuration: Configuration,
        formulation: Formulation | None = None,
        disturbance: Disturbance | None = None,
    ) -> None:
        self.configuration, self._disturbance = configuration, disturbance
        self.plant: Plant = plant_of(configuration)
        self.target = SteeredTarget(configuration.target)
        self.sensor = TargetSensor(configuration.target, self.target)
        self._parameters = _paced(configuration.controller, self.plant)
        self.controller = self._new_controller(formulation)
        period = self.plant.period
        self.rate = configuration.simulator.state_rate if period is None else 1.0 / period
        self._ticks_of_target = max(1, round(self.rate / configuration.target.rate))
        self._changes = deque(configuration.changes)
        self._ticks, self._recorder = 0, _Recorder()
        self._began, self._failsafes = 0.0, 0  # of the present plant [s], and before it

    @property
    def time(self) -> float:
        """Of the next tick in [s]."""
        return self._ticks / self.rate

    def tick(self) -> Tick:
        """Measure, answer, fly on.

        Raises:
            ParameterError: What the configuration changes now cannot be changed in flight.
            SimulationError: The flight left what the plant can describe.
        """
        now, plant, began = self.time, self.plant, self._began
        while self._changes and self._changes[0][0] <= now:
            self._change(now, self._changes.popleft()[1])
        truth = self._sample()
        if self._ticks % self._ticks_of_target == 0:
            self.sensor.measure(now)
        sightings = self.sensor.delivered(now)
        measured = plant.measured()
        if began:
            measured = replace(measured, stamp=measured.stamp + began)
        if self.controller.formulation is not None:  # each change of parameters sets a budget again
            self.controller.formulation.solver.time_limit = math.inf
        command = self.answer(sightings, measured, now)
        self._recorder.mode(now, self.controller.modes.mode, self.controller.modes.reason)
        self._recorder.health(now, self.controller.navigator.air_estimate.health.states)
        if command is not None:
            self._recorder.command(command, self.controller.parameters)
            factors = self.controller.response.softening.factors
            self._recorder.softened = max(self._recorder.softened, *factors.tolist())
            starts = command.stamp - began + command.step * np.arange(len(command.inputs))
            inputs = command.inputs
            if self._disturbance is not None:
                inputs = inputs + self._disturbance(now)
            plant.accept(inputs, starts)
            if command.flown_orbit is not None:
                plant.see_orbit(command.flown_orbit)
        plant.advance(1.0 / self.rate)
        self._ticks += 1
        return Tick(now, truth, measured, command)

    def _change(self, now: float, assignment: str) -> None:
        """Change one parameter in flight: ``SECTION.PARAMETER=VALUE``."""
        sections: Sections = {"uav_simulator": {}, "target_publisher": {}, "nmpc_controller": {}}
        override(sections, assignment)
        simulator, target, controller = sections.values()
        if simulator:
            self.plant.change(changed(self.plant.parameters, simulator))
        if target:
            parameters = changed(self.target.parameters, target)
            self.target.change(now, parameters)
            self.sensor.change(parameters)
        if controller:
            self.controller.change(**controller)

    def answer(self, sightings: Sightings, measured: Measurement, now: float) -> Command | None:
        """Command for what has arrived; a loop in which messages get lost overrides this.

        Args:
            sightings: Time of measuring in [s] and position, shape (3,), in [m] of each measurement
                of the target that has arrived.
            measured: Of the aircraft.
            now: Time in [s].
        """
        for stamp, position in sightings:
            self.controller.see_target(stamp, position)
        return self.controller.step(measured, now)

    def reset(self) -> None:
        """Put the aircraft back where it started, in the present air; time goes on.

        Raises:
            SimulationError: The plant cannot start in it.
        """
        plant = plant_of(replace(self.configuration, simulator=self.plant.parameters))
        self._failsafes += self.plant.plan.failsafes
        self.plant, self._began = plant, self.time

    def restart_controller(self) -> None:
        """Put a new controller in its place, with the parameters of the start.

        It takes over the formulation, which forgets the flight, for the problem is the same.
        """
        self.controller = self._new_controller(self.controller.formulation)

    def log(self, duration: float) -> FlightLog:
        """Record of the flight so far.

        Args:
            duration: Length of the mission in [s].

        Raises:
            SimulationError: There was no command, or the plant has left what it can describe.
        """
        recorder, tracking, plant = self._recorder, self.configuration.controller, self.plant
        if not recorder.commands:
            raise SimulationError(
                f"the target was never seen in {duration:g} s: see "
                "target_publisher.dropout and target_publisher.delay"
            )
        with suppress(Exception):  # of a plant that has failed there is all that was flown before
            self._sample()
        formulation, modes = self.controller.formulation, recorder.modes
        samples = np.array(recorder.samples).reshape(-1, SAMPLE).T
        commands = np.array(recorder.commands).reshape(-1, 7).T
        return FlightLog(
            config=self.configuration.name,
            duration=duration,
            speed=0.0,
            model=tracking.model,
            plant=plant.name,
            orbit=recorder.orbit,
            orbits=recorder.orbits,
            input_lower=tracking.input_lower,
            input_upper=tracking.input_upper,
            time=samples[0],
            vehicle=samples[1:7].T,
            target=samples[11:14].T,
            command_time=commands[0],
            inputs=commands[1:4].T,
            cost=commands[4],
            solve_time=commands[5],
            solver="none" if formulation is None else formulation.solver.name,
            failures=recorder.failures,
            commands=CommandCounts(
                sent=commands.shape[1],
                plan_reused=modes[FallbackMode.EARLIER_PLAN],
                failsafe=self._failsafes
                + plant.plan.failsafes
                + modes[FallbackMode.LOITER]
                + modes[FallbackMode.HOLD],
            ),
            ground_velocity=samples[7:10].T,
            target_velocity=samples[14:17].T,
            nominal=commands[6] > 0.0,
            turn_rate=samples[10],
            modes=tuple(recorder.flown_modes),
            tracking=tracking,
            softened=recorder.softened,
            sensors=tuple(recorder.sensors),
            measured_bank=None if np.isnan(samples[17]).any() else samples[17],
        )

    def _sample(self) -> Measurement:
        """The true state at the time of the next tick, recorded once."""
        now = self.time
        self.plant.time = now - self._began  # sums of floats would drift away from the stamps
        try:
            truth = self.plant.truth
        except ValueError as error:
            raise SimulationError(f"at {now:g} s the plant's {error}") from error
        if len(self._recorder.samples) <= SAMPLE * self._ticks:
            self._recorder.sample(now, truth, self.target)
        return truth

    def _new_controller(self, formulation: Formulation | None) -> Controller:
        if formulation is not None:
            formulation.change(self._parameters)
        return Controller(self._parameters, formulation, stopwatch=lambda: self.time)


def simulate(
    configuration: Configuration,
    progress: Progress | None = None,
    disturbance: Disturbance | None = None,
    witness: Witness | None = None,
    formulation: Formulation | None = None,
) -> FlightLog:
    """Fly the mission of a configuration on the plant that it names: see :class:`ClosedLoop`.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.
        disturbance: Added to commands on their way to the plant, of which the controller does not
            know: called with their time in [s], answers (u_psi, u_chi, u_v), shape (3,).
        witness: Called after each tick with its time in [s], what was measured and what the
            controller answered.
        formulation: That another flight may have used, of a problem that differs in nothing fixed;
            it is set to these parameters. Made by default.

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The flight left what the plant can describe, or the target was never seen.
    """
    loop = ClosedLoop(configuration, formulation, disturbance)
    duration = configuration.mission.duration
    for _ in range(max(1, round(duration * loop.rate))):
        now, _, measured, command = loop.tick()
        if witness is not None:
            witness(now, measured, command)
        if progress is not None and command is not None:
            progress(now)
    return loop.log(duration)


def _paced(parameters: TrackingParameters, plant: Plant) -> TrackingParameters:
    """The controller's parameters; a plant with a period of its own gets a command in each."""
    if plant.period is None:
        return parameters
    timeout = max(parameters.state_timeout, 2.0 * plant.period)
    return changed(parameters, {"control_rate": 1.0 / plant.period, "state_timeout": timeout})
