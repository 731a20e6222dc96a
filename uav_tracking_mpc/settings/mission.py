"""What the commands add to the parameters of the nodes: the mission, and a scenario's words."""

from __future__ import annotations

from dataclasses import dataclass

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.parameters.registry import PLANT
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class MissionParameters:
    """What `fly` and `simulate` add to the nodes: how long, how fast, on which plant."""

    duration: float = parameter(
        paper.DURATION, "Length of the mission, simulated time.", "s", 1.0, 1e6
    )
    speed: float = parameter(10.0, "Simulated over wall time in fly.", lower=0.01, upper=100.0)
    plant: str = parameter(
        "vehicle",
        "What simulate flies: the exact vehicle in moving air, or euler, the prediction model "
        "itself advanced by Euler's method, which knows no wind and no lag.",
        extension=PLANT,
    )


@dataclass(frozen=True)
class ScenarioParameters:
    """What a scenario is; no node reads it."""

    title: str = parameter("", "What it is called.")
    description: str = parameter("", "What happens in it.")
