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

"""The classical laws in the air of a simulated flight, about its target: what they would fly."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np

from uav_tracking_mpc.parameters.registry import names_of
from uav_tracking_mpc.parameters.specification import ParameterError, changed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.simulation.plants import AIR, SimulationError
from uav_tracking_mpc.simulation.steered_target import TargetSensor
from uav_tracking_mpc.view.watched_flight import RivalSight

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
            except (ParameterError, SimulationError) as error:
                logger.warning("%s is not flown beside: %s", law, error)

    def follow(self) -> tuple[RivalSight, ...]:
        """Fly on by the tick that the leader has flown; one that cannot go on is left behind."""
        if self._wanted and self._plant is not self._leader.plant:  # it was put back to its start
            self.fly(True)
        seen = []
        for rival in list(self._flying):
            try:
                seen.append(rival.follow())
            except (ParameterError, SimulationError) as error:
                logger.warning("%s is left behind: %s", rival.law, error)
                self._flying.remove(rival)
        return tuple(seen)
