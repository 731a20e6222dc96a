"""The mission without ROS: plant and controller in turn, deterministic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import Rung
from uav_tracking_mpc.control.pace import Pace
from uav_tracking_mpc.control.pilot import Command, Outlook, Pilot
from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.dynamics.relative import (
    rates_function,
    relative_state,
    steady_inputs,
    vehicle_state,
)
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant
from uav_tracking_mpc.simulation.target_sensor import TargetSensor

Progress = Callable[[float], None]


class LoiterLaw(Protocol):
    """A law that answers a situation at once, such as those in ``guidance``."""

    name: str

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """Inputs (u_psi, u_chi, u_v), shape (3,)."""
        ...


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
        rungs = [command.rung for command in commands]
        solutions = [command.solution for command in commands]
        unsolved = sum(solution is not None and not solution.converged for solution in solutions)
        off_plan = sum(not rung.planned for rung in rungs)
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
                plan_reused=rungs.count(Rung.EARLIER_PLAN),
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
    pilot = Pilot(tracking)
    rates = rates_function(tracking.model)
    step = tracking.horizon_step
    target = motion_of(configuration.target).position(0.0)
    relative, heading = relative_state(start, target), float(start[3])
    still = np.zeros(3)
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
        situation = Situation(vehicle, target, still, still, still)
        forecast = steady_forecast(situation, tracking.horizon)
        command = pilot.step(k * step, Outlook(situation, forecast))
        recorder.commands.append((k * step, command))
        inputs = command.inputs[0]
        relative = relative + step * np.array(rates(relative, inputs)).ravel()  # (10)
        relative[1] = wrap_angle(relative[1])
        heading += step * inputs[0]
        progress((k + 1) * step)
    if relative[0] > abs(relative[2]):
        vehicle = vehicle_state(relative, float(heading - relative[1] - np.pi), target)
        recorder.states.append(((k + 1) * step, vehicle, target))
    return recorder.log(configuration, "euler", pilot.formulation.solver.name, 0)


def fly_vehicle(
    configuration: Configuration, progress: Progress | None = None, law: LoiterLaw | None = None
) -> FlightLog:
    """Fly the exact vehicle at the rates at which the nodes run.

    Args:
        configuration: What to fly.
        progress: Called with the simulated time in [s] after each control step.
        law: Flown in the place of the predictive controller, with the same navigation.

    Raises:
        SimulationError: The target was never seen.
    """
    tracking, simulator = configuration.controller, configuration.simulator
    plant = VehiclePlant(simulator)
    navigator = Navigator(tracking)
    pilot = Pilot(tracking) if law is None else None
    sensor = TargetSensor(configuration.target, motion_of(configuration.target))
    recorder = _Recorder()
    tick = 1.0 / simulator.state_rate
    pace = Pace(tracking.control_rate)
    target_ticks = max(1, round(simulator.state_rate / configuration.target.rate))
    count = round(configuration.mission.duration * simulator.state_rate)
    for k in range(count + 1):
        now = k * tick
        target = motion_of(configuration.target).position(now)
        recorder.states.append((now, plant.state, target))
        recorder.velocities.append(
            (plant.ground_velocity, motion_of(configuration.target).velocity(now))
        )
        if k % target_ticks == 0:
            sensor.measure(now)
        for stamp, position in sensor.delivered(now):
            navigator.see_target(stamp, position)
        if k < count and navigator.target.time is not None and pace.due(round(now * 1e9)):
            seen = plant.measured()
            situation = navigator.situation(
                now,
                seen.state(seen.airspeed or 0.0),
                seen.ground_velocity,
                (seen.turn_rate, seen.path_angle_rate),
            )
            if pilot is not None:
                fresh = now - navigator.target.time <= tracking.target_timeout
                command = pilot.step(now, Outlook(*navigator.at_effect(now, situation), fresh))
            else:
                assert law is not None
                inputs = law.inputs(situation)[np.newaxis]
                command = Command(inputs, 1.0, Rung.LOITER, "", None, tracking.orbit, None)
            navigator.commanded(now, command.inputs, command.step)
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
    solver = pilot.formulation.solver.name if pilot is not None else "none"
    return recorder.log(configuration, "vehicle", solver, plant.plan.failsafes)
