"""The closed loop: a plant, a target and the controller that flies, in turn, deterministic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.formulation.formulation import Formulation
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog
from uav_tracking_mpc.simulation.motions import TargetMotion, motion_of
from uav_tracking_mpc.simulation.plants import Plant, SimulationError, plant_of
from uav_tracking_mpc.simulation.target_sensor import TargetSensor

Progress = Callable[[float], None]
Witness = Callable[[float, Measurement, Command | None], None]
Disturbance = Callable[[float], NDArray[np.float64]]


class _Recorder:
    """Collects a flight sample by sample."""

    def __init__(self, plant: Plant, motion: TargetMotion) -> None:
        self._plant, self._motion = plant, motion
        self.times: list[float] = []
        self.vehicles: list[NDArray[np.float64]] = []
        self.ground_velocities: list[NDArray[np.float64]] = []
        self.targets: list[NDArray[np.float64]] = []
        self.target_velocities: list[NDArray[np.float64]] = []
        self.commands: list[Command] = []

    def sample(self, now: float) -> None:
        try:
            truth = self._plant.truth
        except ValueError as error:
            raise SimulationError(f"at {now:g} s the plant's {error}") from error
        self.times.append(now)
        self.vehicles.append(truth.state(np.nan if truth.airspeed is None else truth.airspeed))
        self.ground_velocities.append(truth.ground_velocity)
        self.targets.append(self._motion.position(now))
        self.target_velocities.append(self._motion.velocity(now))

    def log(self, configuration: Configuration, controller: Controller) -> FlightLog:
        tracking, commands, plant = configuration.controller, self.commands, self._plant
        modes = [command.mode for command in commands]
        solutions = [command.solution for command in commands]
        formulation = controller.formulation
        return FlightLog(
            config=configuration.name,
            duration=configuration.mission.duration,
            speed=0.0,
            model=tracking.model,
            plant=plant.name,
            orbit=commands[-1].orbit,
            input_lower=tracking.input_lower,
            input_upper=tracking.input_upper,
            time=np.array(self.times),
            vehicle=np.array(self.vehicles),
            target=np.array(self.targets),
            command_time=np.array([command.stamp for command in commands]),
            inputs=np.array([command.inputs[0] for command in commands]),
            cost=np.array([np.nan if s is None else s.cost for s in solutions]),
            solve_time=np.array([np.nan if s is None else s.solve_time for s in solutions]),
            solver="none" if formulation is None else formulation.solver.name,
            failures=sum(s is not None and not s.converged for s in solutions),
            commands=CommandCounts(
                sent=len(commands),
                plan_reused=modes.count(FallbackMode.EARLIER_PLAN),
                failsafe=plant.plan.failsafes
                + modes.count(FallbackMode.LOITER)
                + modes.count(FallbackMode.HOLD),
            ),
            ground_velocity=np.array(self.ground_velocities),
            target_velocity=np.array(self.target_velocities),
            nominal=np.array([mode.nominal for mode in modes]),
        )


def simulate(
    configuration: Configuration,
    progress: Progress | None = None,
    disturbance: Disturbance | None = None,
    witness: Witness | None = None,
    formulation: Formulation | None = None,
) -> FlightLog:
    """Fly the mission of a configuration on the plant that it names.

    Plant, sensors and target run at the rates at which the nodes run. The controller takes no time
    to answer: a flight depends on nothing but its configuration, unless a solve meets its budget.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.
        disturbance: Added to commands on their way to the plant, of which the controller does not
            know: called with their time in [s], answers (u_psi, u_chi, u_v), shape (3,).
        witness: Called at each tick with the time in [s], what is measured and what the controller
            answers.
        formulation: That another flight may have used, of a problem that differs in nothing fixed;
            it is set to these parameters. Made by default.

    Raises:
        ParameterError: There is no such plant, motion or law, or the parameters cannot be flown.
        SimulationError: The flight left what the plant can describe, or the target was never seen.
    """
    plant, motion = plant_of(configuration), motion_of(configuration.target)
    parameters = _paced(configuration.controller, plant)
    if formulation is not None:
        formulation.change(parameters)
    controller = Controller(parameters, formulation, stopwatch=lambda: 0.0)
    sensor, recorder = TargetSensor(configuration.target, motion), _Recorder(plant, motion)
    rate = configuration.simulator.state_rate if plant.period is None else 1.0 / plant.period
    ticks_of_target = max(1, round(rate / configuration.target.rate))
    count = max(1, round(configuration.mission.duration * rate))
    for tick in range(count + 1):
        now = tick / rate
        plant.time = now  # sums of floats would drift away from the stamps
        recorder.sample(now)
        if tick == count:
            break
        if tick % ticks_of_target == 0:
            sensor.measure(now)
        for stamp, position in sensor.delivered(now):
            controller.see_target(stamp, position)
        measured = plant.measured()
        command = controller.step(measured, now)
        if witness is not None:
            witness(now, measured, command)
        if command is not None:
            recorder.commands.append(command)
            starts = command.stamp + command.step * np.arange(len(command.inputs))
            inputs = command.inputs
            if disturbance is not None:
                inputs = inputs + disturbance(now)
            plant.accept(inputs, starts)
            if command.flown_orbit is not None:
                plant.see_orbit(command.flown_orbit)
            if progress is not None:
                progress(now)
        plant.advance(1.0 / rate)
    if not recorder.commands:
        raise SimulationError(
            f"the target was never seen in {configuration.mission.duration:g} s: see "
            "target_publisher.dropout and target_publisher.delay"
        )
    return recorder.log(configuration, controller)


def _paced(parameters: TrackingParameters, plant: Plant) -> TrackingParameters:
    """The controller's parameters; a plant with a period of its own gets a command in each."""
    if plant.period is None:
        return parameters
    timeout = max(parameters.state_timeout, 2.0 * plant.period)
    return changed(parameters, {"control_rate": 1.0 / plant.period, "state_timeout": timeout})
