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

"""What is simulated: the aircraft and its air, the target, and the mission, as parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.energy_hold import HoldParameters
from uav_tracking_mpc.dynamics.relative import vehicle_state
from uav_tracking_mpc.dynamics.vehicle import VehicleState
from uav_tracking_mpc.parameters.specification import ParameterError, Parameters, parameter
from uav_tracking_mpc.settings.frame_parameters import FrameParameters, MapFrameParameters

START = VehicleState(*vehicle_state(paper.INITIAL_STATE, 0.0, np.zeros(3)).tolist())


@dataclass(frozen=True)
class SimulatorParameters(HoldParameters, FrameParameters):
    """Where the simulated vehicle starts and what it can do.

    The default start is the paper's x_o (Section 6) about a target at the origin; the paper leaves
    the azimuth free, here it is East.

    Raises:
        ParameterError: A lower limit is not below its upper limit, or the start is outside them.
    """

    plant: str = parameter(
        "vehicle", "What flies.", extension="uav_tracking_mpc.simulation.plants", fixed=True
    )
    initial_position: tuple[float, ...] = parameter(
        (START.x, START.y, START.z),
        "Position at the start in map.",
        "m",
        -1e6,
        1e6,
        size=3,
        fixed=True,
    )
    initial_heading: float = parameter(
        START.heading,
        "Heading at the start, counter-clockwise from East.",
        "rad",
        -math.pi,
        math.pi,
        fixed=True,
    )
    initial_path_angle: float = parameter(
        START.path_angle, "Path angle at the start, positive up.", "rad", -1.5, 1.5, fixed=True
    )
    initial_speed: float = parameter(
        START.airspeed, "Speed at the start.", "m/s", 0.0, 400.0, fixed=True
    )
    state_rate: float = parameter(
        20.0, "How often the state is published.", "Hz", 1.0, 1000.0, fixed=True
    )
    speed: float = parameter(
        1.0, "Simulated over wall time, when /clock is driven.", lower=0.01, upper=1000.0
    )
    publish_clock: bool = parameter(
        False, "Drive /clock; the other nodes then need use_sim_time.", fixed=True
    )
    wait_for_subscribers: int = parameter(
        0,
        "Time stands still until so many listen to the state; page and monitor do not count.",
        lower=0,
        upper=100,
        fixed=True,
    )
    start_on_command: bool = parameter(
        False, "Hold the vehicle where it starts until the first command arrives.", fixed=True
    )
    yaw_rate_max: float = parameter(
        paper.TURN_RATE_BOUND, "Yaw rates beyond this are cut.", "rad/s", 1e-3, 10.0, fixed=True
    )
    pitch_rate_max: float = parameter(
        paper.PATH_ANGLE_RATE_BOUND,
        "Path-angle rates beyond this are cut.",
        "rad/s",
        1e-3,
        10.0,
        fixed=True,
    )
    acceleration_min: float = parameter(
        -paper.ACCELERATION_BOUND,
        "Accelerations below this are cut.",
        "m/s^2",
        -100.0,
        -1e-3,
        fixed=True,
    )
    acceleration_max: float = parameter(
        paper.ACCELERATION_BOUND,
        "Accelerations above this are cut.",
        "m/s^2",
        1e-3,
        100.0,
        fixed=True,
    )
    speed_min: float = parameter(
        0.0, "The vehicle does not fly slower.", "m/s", 0.0, 400.0, fixed=True
    )
    speed_max: float = parameter(
        20.0, "The vehicle does not fly faster.", "m/s", 0.1, 400.0, fixed=True
    )
    bank_max: float = parameter(
        0.5 * math.pi,
        "Yaw rates beyond the coordinated turn at this bank, g tan(bank_max) / v, are cut.",
        "rad",
        0.01,
        0.5 * math.pi,
        fixed=True,
    )
    rate_lag: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Time constants with which yaw rate, path-angle rate and acceleration follow commands.",
        "s",
        0.0,
        10.0,
        size=3,
        fixed=True,
    )
    dead_time: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Dead times before yaw rate, path-angle rate and acceleration begin to follow.",
        "s",
        0.0,
        5.0,
        size=3,
        fixed=True,
    )
    command_gain: tuple[float, ...] = parameter(
        (1.0, 1.0, 1.0),
        "Share of commanded yaw rate, path-angle rate and acceleration that is flown in the end.",
        lower=0.1,
        upper=10.0,
        size=3,
        fixed=True,
    )
    command_delay: float = parameter(
        0.0, "How much later than it was sent a command reaches the aircraft.", "s", 0.0, 5.0
    )
    roll_frequency: float = parameter(
        0.0,
        "Natural frequency with which the yaw rate follows its command, instead of with its lag; "
        "0 for the lag.",
        "rad/s",
        0.0,
        100.0,
        fixed=True,
    )
    roll_damping: float = parameter(
        0.6, "Damping ratio that belongs to roll_frequency.", lower=0.05, upper=0.99, fixed=True
    )
    wind: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Mean velocity of the air in map: where it blows to.",
        "m/s",
        -100.0,
        100.0,
        size=3,
    )
    gust_intensity: float = parameter(
        0.0,
        "Dryden gusts: W20, wind speed at 20 ft; 7.7 is light, 15.4 moderate, 23.2 severe.",
        "m/s",
        0.0,
        50.0,
    )
    position_noise: float = parameter(
        0.0, "Standard deviation of the measured position, each axis.", "m", 0.0, 1e3
    )
    velocity_noise: float = parameter(
        0.0, "Standard deviation of the measured ground velocity, each axis.", "m/s", 0.0, 100.0
    )
    attitude_noise: float = parameter(
        0.0, "Standard deviation of the measured heading and path angle.", "rad", 0.0, 1.0
    )
    airspeed_noise: float = parameter(
        0.0, "Standard deviation of the measured airspeed.", "m/s", 0.0, 100.0
    )
    velocity_bias: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Constant error of the measured ground velocity in map.",
        "m/s",
        -50.0,
        50.0,
        size=3,
    )
    heading_bias: float = parameter(
        0.0, "Constant error of the measured heading.", "rad", -math.pi, math.pi
    )
    airspeed_bias: float = parameter(
        0.0, "Constant error of the measured airspeed.", "m/s", -50.0, 50.0
    )
    airspeed_fault: str = parameter(
        "none",
        "Of the airspeed sensor: stuck at its reading, blocked (reads the pressure that is left in "
        "it against that of the height), or silent.",
        choices=("none", "stuck", "blocked", "silent"),
    )
    position_bias: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0), "Constant error of the measured position.", "m", -1e4, 1e4, size=3
    )
    position_fault: str = parameter(
        "none",
        "Of the positions: frozen at the one measured last, level (only the height is), or silent; "
        "then no state is published.",
        choices=("none", "frozen", "level", "silent"),
    )
    heading_fault: str = parameter(
        "none", "Of the heading: stuck at the one measured last.", choices=("none", "stuck")
    )
    velocity_fault: str = parameter(
        "none", "Of the ground velocity: stuck at the one measured last.", choices=("none", "stuck")
    )
    velocity_gain: float = parameter(
        1.0, "Share of the ground velocity that is measured; -1 turns its sign.", "", -2.0, 2.0
    )
    turn_rate_bias: float = parameter(
        0.0, "Constant error of the measured turn rate.", "rad/s", -1.0, 1.0
    )
    state_delay: float = parameter(
        0.0,
        "How much later than it was measured the state is published.",
        "s",
        0.0,
        5.0,
        fixed=True,
    )
    state_stamp_true: bool = parameter(
        True,
        "Stamp a late state with when it was measured; else with when it is published.",
        fixed=True,
    )
    seed: int = parameter(
        0, "Seed of gusts and sensor noise.", lower=0, upper=2**31 - 1, fixed=True
    )

    def __post_init__(self) -> None:
        """Check the speed limits against each other and the start."""
        super().__post_init__()
        if not self.speed_min < self.speed_max:
            raise ParameterError(
                f"parameter 'speed_min' is {self.speed_min}, must be below 'speed_max' = "
                f"{self.speed_max} m/s"
            )
        if not self.speed_min <= self.initial_speed <= self.speed_max:
            raise ParameterError(
                f"parameter 'initial_speed' is {self.initial_speed}, must be from 'speed_min' = "
                f"{self.speed_min} to 'speed_max' = {self.speed_max} m/s"
            )

    @property
    def initial_state(self) -> NDArray[np.float64]:
        """(x, y, z, psi, chi, v) at the start, shape (6,)."""
        return np.array(
            [
                *self.initial_position,
                self.initial_heading,
                self.initial_path_angle,
                self.initial_speed,
            ]
        )


MEASURED = ("rate", "noise", "dropout", "delay", "seed")  # what is not about the motion


@dataclass(frozen=True)
class TargetParameters(MapFrameParameters):
    """Motion and measurement of the target.

    Raises:
        ParameterError: The waypoints hold fewer than two different points.
    """

    motion: str = parameter(
        "stationary", "How the target moves.", extension="uav_tracking_mpc.simulation.motions"
    )
    position: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Where it stands or starts in map; for a circle, its centre.",
        "m",
        -1e6,
        1e6,
        size=3,
    )
    speed: float = parameter(
        0.0, "Speed along its path; ignored when stationary.", "m/s", 0.0, 100.0
    )
    heading: float = parameter(
        0.0,
        "Direction of a straight run, or azimuth of a circle's start, from East.",
        "rad",
        -2.0 * math.pi,
        2.0 * math.pi,
    )
    radius: float = parameter(100.0, "Radius of a circle.", "m", 0.1, 1e5)
    waypoints: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 100.0, 0.0, 0.0),
        "x, y, z of one point after the other, visited in turn and from the start again.",
        "m",
        -1e6,
        1e6,
        multiple=3,
    )
    drive_time: float = parameter(
        20.0, "How long stop_and_go and zigzag drive at a time, straight on.", "s", 0.1, 1e5
    )
    stand_time: float = parameter(20.0, "How long stop_and_go stands in between.", "s", 0.1, 1e5)
    weave_speed: float = parameter(
        3.0, "Greatest speed across its way with which weaving swings.", "m/s", 0.0, 100.0
    )
    weave_period: float = parameter(8.0, "Period of weaving.", "s", 0.1, 1e5)
    jump_time: float = parameter(
        60.0, "When jump, otherwise a straight run, is somewhere else at once.", "s", 0.0, 1e6
    )
    jump_offset: tuple[float, ...] = parameter(
        (100.0, 0.0, 0.0), "By how much it is moved.", "m", -1e6, 1e6, size=3
    )
    rate: float = parameter(
        10.0, "How often the position is measured.", "Hz", 0.1, 1000.0, fixed=True
    )
    noise: float = parameter(
        0.0, "Standard deviation of the measured position, each axis.", "m", 0.0, 1e3
    )
    dropout: float = parameter(
        0.0, "Probability with which a measurement is lost.", lower=0.0, upper=1.0
    )
    delay: float = parameter(
        0.0,
        "How late a measurement is published; its stamp is the time of measuring.",
        "s",
        0.0,
        60.0,
        fixed=True,
    )
    seed: int = parameter(0, "Seed of noise and dropouts.", lower=0, upper=2**31 - 1, fixed=True)

    def __post_init__(self) -> None:
        """Check that the waypoints make a path."""
        super().__post_init__()
        points = {self.waypoints[first : first + 3] for first in range(0, len(self.waypoints), 3)}
        if len(points) < 2:
            raise ParameterError(
                f"parameter 'waypoints' is {list(self.waypoints)}, must hold at least two "
                "different points"
            )


@dataclass(frozen=True)
class MissionParameters(Parameters):
    """What `fly` and `simulate` add to the nodes: how long, how fast, on which plant."""

    duration: float = parameter(
        paper.DURATION, "Length of the mission, simulated time.", "s", 1.0, 1e6
    )
    speed: float = parameter(
        10.0,
        "Simulated over wall time in fly and simulate --view; simulate alone is as fast as it can.",
        lower=0.01,
        upper=100.0,
    )
    plant: str = parameter(
        "vehicle",
        "What simulate flies: the exact vehicle in moving air, or euler, the prediction model "
        "itself advanced by Euler's method, which knows no wind and no lag.",
        extension="uav_tracking_mpc.simulation.plants",
    )


@dataclass(frozen=True)
class ScenarioParameters(Parameters):
    """What a scenario is; no node reads it."""

    title: str = parameter("", "What it is called.")
    description: str = parameter("", "What happens in it.")
