"""The mission without ROS: plant and controller in turn, deterministic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.relative import rates_function, relative_state, vehicle_state
from uav_tracking_mpc.guidance.controller import Command, Source, TrackingController
from uav_tracking_mpc.guidance.pace import Pace
from uav_tracking_mpc.guidance.target_filter import TargetFilter
from uav_tracking_mpc.simulation.configuration import Configuration
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog
from uav_tracking_mpc.simulation.plant import Plant
from uav_tracking_mpc.simulation.target_motion import target_position

Progress = Callable[[float], None]


class SimulationError(RuntimeError):
    """The flight left what the model can describe; the message says where."""


class _Recorder:
    """Collects a flight sample by sample."""

    def __init__(self) -> None:
        self.states: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
        self.commands: list[tuple[float, Command]] = []

    def log(
        self, configuration: Configuration, plant: str, solver: str, failsafes: int
    ) -> FlightLog:
        tracking = configuration.controller
        times, vehicles, targets = zip(*self.states, strict=True)
        stamps, commands = zip(*self.commands, strict=True)
        optimal = [command.source is Source.OPTIMAL for command in commands]
        reused = [command.source is Source.EARLIER_PLAN for command in commands]
        return FlightLog(
            config=configuration.name,
            duration=configuration.mission.duration,
            speed=0.0,
            model=tracking.model,
            plant=plant,
            orbit=tracking.orbit,
            input_lower=tracking.input_lower,
            input_upper=tracking.input_upper,
            steady_inputs=tracking.steady_inputs,
            time=np.array(times),
            vehicle=np.array(vehicles),
            target=np.array(targets),
            command_time=np.array(stamps),
            inputs=np.array([command.inputs[0] for command in commands]),
            cost=np.array([command.solution.cost for command in commands]),
            solve_time=np.array([command.solution.solve_time for command in commands]),
            solver=solver,
            failures=len(optimal) - sum(optimal),
            commands=CommandCounts(sent=len(commands), plan_reused=sum(reused), failsafe=failsafes),
        )


def simulate(configuration: Configuration, progress: Progress | None = None) -> FlightLog:
    """Fly the mission of a configuration on the plant that it names.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.
    """
    flown = _euler_mission if configuration.mission.plant == "euler" else _vehicle_mission
    return flown(configuration, progress or (lambda time: None))


def _euler_mission(configuration: Configuration, progress: Progress) -> FlightLog:
    """Section 6 as the paper ran it: the prediction model itself, by Euler's method, is flown.

    One command a step T_s; the target stands still, as (9) demands.
    """
    tracking, start = configuration.controller, configuration.simulator.initial_state
    controller = TrackingController(tracking)
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
        command = controller.step(relative, step if k else None)
        recorder.commands.append((k * step, command))
        inputs = command.inputs[0]
        relative = relative + step * np.array(rates(relative, inputs)).ravel()  # (10)
        relative[1] = wrap_angle(relative[1])
        heading += step * inputs[0]
        progress((k + 1) * step)
    if relative[0] > abs(relative[2]):
        vehicle = vehicle_state(relative, float(heading - relative[1] - np.pi), target)
        recorder.states.append(((k + 1) * step, vehicle, target))
    return recorder.log(configuration, "euler", controller.solver.name, 0)


def _vehicle_mission(configuration: Configuration, progress: Progress) -> FlightLog:
    """The exact vehicle, at the rates at which the nodes run."""
    tracking, simulator = configuration.controller, configuration.simulator
    controller = TrackingController(tracking)
    plant = Plant(simulator)
    measured = TargetFilter(tracking.target_noise, tracking.target_agility)
    noise = np.random.default_rng(configuration.target.seed)
    recorder = _Recorder()
    tick = 1.0 / simulator.state_rate
    pace, last = Pace(tracking.control_rate), 0.0
    target_ticks = max(1, round(simulator.state_rate / configuration.target.rate))
    count = round(configuration.mission.duration * simulator.state_rate)
    for k in range(count + 1):
        now = k * tick
        target = target_position(configuration.target, now)
        recorder.states.append((now, plant.state, target))
        if k % target_ticks == 0:
            measured.update(now, target + configuration.target.noise * noise.standard_normal(3))
        if k < count and pace.due(round(now * 1e9)):
            relative = relative_state(plant.state, measured.predict(now).position)
            command = controller.step(relative, now - last if k else None)
            last = now
            recorder.commands.append((now, command))
            plant.accept(command.inputs, now + command.step * np.arange(len(command.inputs)))
            progress(now)
        plant.advance(tick)
    return recorder.log(configuration, "vehicle", controller.solver.name, plant.failsafes)
