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

"""Every law through every scenario: the same aircraft, the same air, the same measurements."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from uav_tracking_mpc.control.direction import nearest_direction
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.settings.configuration import Configuration, scenario_names
from uav_tracking_mpc.settings.tracking import NEAREST
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant
from uav_tracking_mpc.studies.parallel import StoppedError, parallel_map

# From easy to hard; scenarios that are not named come after these.
ORDER = (
    "still", "wind", "crosswind", "headwind", "tight_headwind", "circling_target", "gusts",
    "noisy_target",
)  # fmt: skip


def fly_all(
    configurations: Sequence[Configuration],
    laws: Sequence[str],
    workers: int | None = None,
    show: bool = True,
) -> list[list[FlightLog]]:
    """Fly every law through every scenario; the outcome depends on nothing but the arguments.

    Args:
        configurations: One of each scenario.
        laws: Names of laws, or ``path.py:Class``.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.

    Returns:
        For each configuration a flight of each law; where the user interrupted, of those alone that
        every law has flown by then.

    Raises:
        SimulationError: The target of a scenario was never seen.
        KeyboardInterrupt: The user interrupted before anything was whole.
    """
    tasks = [prepared(each, law) for each in configurations for law in laws]
    try:
        logs = parallel_map(simulate, tasks, workers, "flights", show)
    except StoppedError as stopped:
        logs = stopped.done
        if len(logs) < len(laws):
            raise
    whole = len(logs) // len(laws)
    return [logs[k * len(laws) : (k + 1) * len(laws)] for k in range(whole)]


def prepared(configuration: Configuration, law: str) -> Configuration:
    """The configuration with a law, and what all laws share: the direction.

    Args:
        configuration: Of a scenario.
        law: Name of a law, or ``path.py:Class``.
    """
    controller = dataclasses.replace(
        configuration.controller, law=law, direction=start_direction(configuration)
    )
    # The aircraft, also where the mission is to fly the prediction model.
    mission = dataclasses.replace(configuration.mission, plant=configuration.simulator.plant)
    return dataclasses.replace(configuration, controller=controller, mission=mission)


def start_direction(configuration: Configuration) -> str:
    """Direction of the orbit; where the nearest is asked for, that of the true start.

    Args:
        configuration: Of a scenario.
    """
    if configuration.controller.direction != NEAREST:
        return configuration.controller.direction
    plant, still = VehiclePlant(configuration.simulator), np.zeros(3)
    motion = motion_of(configuration.target)
    drift, target = plant.wind - motion.velocity(0.0), motion.position(0.0)
    return nearest_direction(Situation(plant.state, target, drift, still, still))


def scenarios_in_order() -> list[str]:
    """Names of all scenarios that come with the package, from easy to hard."""
    names = scenario_names()
    return [*(name for name in ORDER if name in names), *(n for n in names if n not in ORDER)]
