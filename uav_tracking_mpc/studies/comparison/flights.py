"""Every law through every scenario: the same aircraft, the same air, the same measurements."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uav_tracking_mpc.control.direction import nearest_direction
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws.l1 import L1Loiter
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import NEAREST, PREDICTIVE
from uav_tracking_mpc.simulation.closed_loop import fly_vehicle
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.plants.vehicle import Plant
from uav_tracking_mpc.simulation.target_motion import target_position, target_velocity
from uav_tracking_mpc.studies.parallel import parallel_map

NMPC = PREDICTIVE
LAWS = (NMPC, L1Loiter.name, VectorField.name)
# Longer than any solve takes: with the budget of a real flight the load of the machine would
# decide which plan is flown, and no flight could be repeated.
SOLVE_TIME_MAX = 10.0  # s


@dataclass(frozen=True)
class Task:
    """One law through one scenario.

    Attributes:
        configuration: Of the scenario.
        law: Name in :data:`LAWS`.
    """

    configuration: Configuration
    law: str


def fly_all(
    configurations: Sequence[Configuration],
    laws: Sequence[str],
    workers: int | None = None,
    show: bool = True,
) -> list[list[FlightLog]]:
    """Fly every law through every scenario; the outcome depends on nothing but the arguments.

    Args:
        configurations: One of each scenario.
        laws: Names in :data:`LAWS`.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.

    Returns:
        For each configuration a flight of each law.

    Raises:
        SimulationError: The target of a scenario was never seen.
    """
    tasks = [Task(prepared(each), law) for each in configurations for law in laws]
    logs = parallel_map(fly, tasks, workers, "flights", show)
    return [logs[begin : begin + len(laws)] for begin in range(0, len(logs), len(laws))]


def prepared(configuration: Configuration) -> Configuration:
    """The configuration with what all laws share: the direction, and time enough to solve."""
    controller = dataclasses.replace(
        configuration.controller,
        direction=start_direction(configuration),
        solve_time_max=SOLVE_TIME_MAX,
    )
    return dataclasses.replace(configuration, controller=controller)


def start_direction(configuration: Configuration) -> str:
    """Direction of the orbit; where the nearest is asked for, that of the true start."""
    if configuration.controller.direction != NEAREST:
        return configuration.controller.direction
    plant, still = Plant(configuration.simulator), np.zeros(3)
    drift = plant.wind - target_velocity(configuration.target, 0.0)
    target = target_position(configuration.target, 0.0)
    return nearest_direction(Situation(plant.state, target, drift, still, still))


def fly(task: Task) -> FlightLog:
    """Fly one law through one scenario."""
    configuration = task.configuration
    controller = dataclasses.replace(configuration.controller, law=task.law)
    return fly_vehicle(dataclasses.replace(configuration, controller=controller))
