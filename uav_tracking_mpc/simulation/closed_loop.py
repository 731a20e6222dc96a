"""The mission without ROS: plant and controller in turn, deterministic."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.relative import (
    rates_function,
    relative_state,
    steady_inputs,
    vehicle_state,
)
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog
from uav_tracking_mpc.simulation.plants.vehicle import Plant
from uav_tracking_mpc.simulation.target_motion import target_position, target_velocity
from uav_tracking_mpc.simulation.target_sensor import TargetSensor

Progress = Callable[[float], None]


class SimulationError(RuntimeError):
    """The flight left what the model can describe; the message says where."""


class _Recorder:
    """Collects a flight sample by sample."""

    def __init__(self) -> None:
        self.states: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
        self.velocities: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
        self.commands: list[tuple[float, Command]] = []

    def log(
        self, configuration: Configuration, plant: str, solver: str, failsafes: int
    ) -> FlightLog:
        tracking = configuration.controller
        times, vehicles, targets = zip(*self.states, strict=True)
        stamps, commands = zip(*self.commands, strict=True)
        # The Euler plant has no wind and a target that stands: it records no velocities.
        ground_velocity, targets_velocity = (
            np.array(self.velocities).transpose(1, 0, 2) if self.velocities else (None, None)
        )
        modes = [command.mode for command in commands]
        solutions = [command.solution for command in commands]
        unsolved = sum(solution is not None and not solution.converged for solution in solutions)
        off_plan = sum(not (mode.planned or mode.nominal) for mode in modes)
        return FlightLog(
            config=configuration.name,
            duration=configuration.mission.duration,
            speed=0.0,
            model=tracking.model,
            plant=plant,
            orbit=commands[-1].orbit,
            input_lower=tracking.input_lower,
            input_upper=tracking.input_upper,
            steady_inputs=steady_inputs(tracking.model, commands[-1].orbit),
            time=np.array(times),
            vehicle=np.array(vehicles),
            target=np.array(targets),
            command_time=np.array(stamps),
            inputs=np.array([command.inputs[0] for command in commands]),
            cost=np.array([np.nan if s is None else s.cost for s in solutions]),
            solve_time=np.array([np.nan if s is None else s.solve_time for s in solutions]),
            solver=solver,
            failures=unsolved,
            commands=CommandCounts(
                sent=len(commands),
                plan_reused=modes.count(FallbackMode.EARLIER_PLAN),
                failsafe=failsafes + off_plan,
            ),
            ground_velocity=ground_velocity,
            target_velocity=targets_velocity,
        )


def simulate(configuration: Configuration, progress: Progress | None = None) -> FlightLog:
    """Fly the mission of a configuration on the plant that it names.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.
    """
    if configuration.mission.plant == "euler":
        return _euler_mission(configuration, progress or (lambda time: None))
    return fly_vehicle(configuration, progress)


def _euler_mission(configuration: Configuration, progress: Progress) -> FlightLog:
    """Section 6 as the paper ran it: the prediction model itself, by Euler's method, is flown.

    One command a step T_s; the target stands still, as (9) demands.
    """
    tracking, start = configuration.controller, configuration.simulator.initial_state
    # One state a step is all that there is: it may be as old as that.
    controller = Controller(
        dataclasses.replace(tracking, state_timeout=2.0 * tracking.horizon_step),
        stopwatch=lambda: 0.0,
    )
    rates = rates_function(tracking.model)
    step = tracking.horizon_step
    target = target_position(configuration.target, 0.0)
    relative, heading = relative_state(start, target), float(start[3])
    recorder = _Recorder()
    for k in range(max(1, round(configuration.mission.duration / step))):
        if not relative[0] > abs(relative[2]):
            raise SimulationError(
                f"at {k * step:g} s the range is {relative[0]:.6g} m at a height of "
                f"{relative[2]:.6g} m: the Euler plant has no value there; fly the vehicle with "
                "--set mission.plant=vehicle"
            )
        vehicle = vehicle_state(relative, float(heading - relative[1] - np.pi), target)  # (4)
        recorder.states.append((k * step, vehicle, target))
        controller.see_target(k * step, target)
        command = controller.step(_measurement(k * step, vehicle, velocity(vehicle)), k * step)
        assert command is not None
        recorder.commands.append((k * step, command))
        inputs = command.inputs[0]
        relative = relative + step * np.array(rates(relative, inputs)).ravel()  # (10)
        relative[1] = wrap_angle(relative[1])
        heading += step * inputs[0]
        progress((k + 1) * step)
    if relative[0] > abs(relative[2]):
        vehicle = vehicle_state(relative, float(heading - relative[1] - np.pi), target)
        recorder.states.append(((k + 1) * step, vehicle, target))
    return recorder.log(configuration, "euler", tracking.solver, 0)


def _measurement(
    time: float,
    state: NDArray[np.float64],
    ground_velocity: NDArray[np.float64],
    rates: tuple[float, float] = (0.0, 0.0),
) -> Measurement:
    heading, path_angle, airspeed = (float(value) for value in state[3:])
    turns = (heading, path_angle, *rates)
    return Measurement(time, state[:3], ground_velocity, *turns, airspeed)


def fly_vehicle(configuration: Configuration, progress: Progress | None = None) -> FlightLog:
    """Fly the exact vehicle at the rates at which the nodes run.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.

    Raises:
        SimulationError: The target was never seen.
    """
    tracking, simulator = configuration.controller, configuration.simulator
    plant = Plant(simulator)
    controller = Controller(tracking, stopwatch=lambda: 0.0)
    sensor = TargetSensor(configuration.target)
    recorder = _Recorder()
    tick = 1.0 / simulator.state_rate
    target_ticks = max(1, round(simulator.state_rate / configuration.target.rate))
    count = round(configuration.mission.duration * simulator.state_rate)
    for k in range(count + 1):
        now = k * tick
        target = target_position(configuration.target, now)
        recorder.states.append((now, plant.state, target))
        recorder.velocities.append(
            (plant.ground_velocity, target_velocity(configuration.target, now))
        )
        if k % target_ticks == 0:
            sensor.measure(now)
        for stamp, position in sensor.delivered(now):
            controller.see_target(stamp, position)
        if k < count:
            state, ground_velocity = plant.measured()
            turn, climb, _ = plant.rates.tolist()
            measurement = _measurement(now, state, ground_velocity, (turn, climb))
            command = controller.step(measurement, now)
            if command is not None:
                recorder.commands.append((now, command))
                plant.accept(command.inputs, now + command.step * np.arange(len(command.inputs)))
                if progress is not None:
                    progress(now)
        plant.advance(tick)
    if not recorder.commands:
        raise SimulationError(
            f"the target was never seen in {configuration.mission.duration:g} s: see "
            "target_publisher.dropout and target_publisher.delay"
        )
    formulation = controller.formulation
    solver = "none" if formulation is None else formulation.solver.name
    return recorder.log(configuration, "vehicle", solver, plant.failsafes)
