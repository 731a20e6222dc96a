"""The simulated aircraft: the exact vehicle (3) behind an autopilot that flies plans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.parameters import ParameterError, parameter

LEVELLING_TIME = 1.0  # s, in which wings-level flight takes the path angle out
LEAD_LIMIT = 1.0  # s, by which a plan may begin in the future


@dataclass(frozen=True)
class SimulatorParameters:
    """Where the simulated vehicle starts and what it can do.

    The default start is the paper's x_o = [212.83, -pi/4, 20, 0, 0] (Section 6) about a target at
    the origin; the paper leaves the azimuth free, here it is East.

    Raises:
        ParameterError: A lower limit is not below its upper limit, or the start is outside them.
    """

    initial_position: tuple[float, ...] = parameter(
        (math.sqrt(212.83**2 - 20.0**2), 0.0, 20.0),
        "Position at the start in map.",
        unit="m",
        size=3,
        lower=-1e6,
        upper=1e6,
    )
    initial_heading: float = parameter(
        0.75 * math.pi,
        "Heading at the start, counter-clockwise from East.",
        unit="rad",
        lower=-math.pi,
        upper=math.pi,
    )
    initial_path_angle: float = parameter(
        0.0, "Path angle at the start, positive up.", unit="rad", lower=-1.5, upper=1.5
    )
    initial_speed: float = parameter(0.0, "Speed at the start.", unit="m/s", lower=0.0, upper=400.0)
    state_rate: float = parameter(
        20.0, "How often the state is published.", unit="Hz", lower=1.0, upper=1000.0
    )
    speed: float = parameter(
        1.0, "Simulated over wall time, when /clock is driven.", lower=0.01, upper=1000.0
    )
    publish_clock: bool = parameter(False, "Drive /clock; the other nodes then need use_sim_time.")
    wait_for_subscribers: int = parameter(
        0, "Time stands still until so many listen to the state.", lower=0, upper=100
    )
    start_on_command: bool = parameter(
        False, "Hold the vehicle where it starts until the first command arrives."
    )
    yaw_rate_max: float = parameter(
        math.pi / 4, "Yaw rates beyond this are cut.", unit="rad/s", lower=1e-3, upper=10.0
    )
    pitch_rate_max: float = parameter(
        math.pi / 4, "Path-angle rates beyond this are cut.", unit="rad/s", lower=1e-3, upper=10.0
    )
    acceleration_min: float = parameter(
        -1.0, "Accelerations below this are cut.", unit="m/s^2", lower=-100.0, upper=-1e-3
    )
    acceleration_max: float = parameter(
        1.0, "Accelerations above this are cut.", unit="m/s^2", lower=1e-3, upper=100.0
    )
    speed_min: float = parameter(
        0.0, "The vehicle does not fly slower.", unit="m/s", lower=0.0, upper=400.0
    )
    speed_max: float = parameter(
        20.0, "The vehicle does not fly faster.", unit="m/s", lower=0.1, upper=400.0
    )

    def __post_init__(self) -> None:
        """Check the speed limits against each other and the start."""
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


class Plant:
    """Vehicle and autopilot: flies the newest plan, then wings level.

    Args:
        parameters: Start and limits.

    Attributes:
        state: (x, y, z, psi, chi, v), shape (6,).
        time: Time of the state in [s].
        holding: Whether it holds wings level because no plan is left.
        failsafes: How often it ran out of plan.
    """

    def __init__(self, parameters: SimulatorParameters) -> None:
        self._parameters = parameters
        self._lower = np.array(
            [-parameters.yaw_rate_max, -parameters.pitch_rate_max, parameters.acceleration_min]
        )
        self._upper = np.array(
            [parameters.yaw_rate_max, parameters.pitch_rate_max, parameters.acceleration_max]
        )
        self.state = parameters.initial_state
        self.time = 0.0
        self.holding = True
        self.failsafes = 0
        self._plan: NDArray[np.float64] | None = None
        self._starts = np.zeros(0)
        self._end = -math.inf

    @property
    def commanded(self) -> bool:
        """Whether a plan has ever arrived."""
        return self._plan is not None

    def accept(self, plan: ArrayLike, starts: ArrayLike) -> None:
        """Take over a plan.

        Args:
            plan: (u_psi, u_chi, u_v) of each segment, shape (n, 3).
            starts: When each segment begins in [s], shape (n,), increasing; the last segment is
                as long as the one before it, a single one lasts 1 s.

        Raises:
            ValueError: Empty, not finite, not in order, older than the present plan, or from the
                future; the present plan stays.
        """
        plan, starts = np.asarray(plan, dtype=float), np.asarray(starts, dtype=float)
        if plan.ndim != 2 or plan.shape[1] != 3 or len(plan) == 0 or starts.shape != (len(plan),):
            raise ValueError(f"plan has shape {plan.shape}, must be (n, 3) with a start for each")
        if not (np.all(np.isfinite(plan)) and np.all(np.isfinite(starts))):
            raise ValueError("plan holds values that are not finite")
        steps = np.diff(starts)
        if np.any(steps <= 0.0):
            raise ValueError("plan's segments are not in order of time")
        if starts[0] > self.time + LEAD_LIMIT:
            raise ValueError(
                f"plan begins {starts[0] - self.time:.3f} s from now, may by {LEAD_LIMIT:g} s"
            )
        if len(self._starts) and starts[0] < self._starts[0]:
            raise ValueError("plan is older than the one that is flown")
        self._plan = np.clip(plan, self._lower, self._upper)
        self._starts = starts
        self._end = starts[-1] + (steps[-1] if len(steps) else 1.0)

    def inputs(self) -> NDArray[np.float64]:
        """Inputs now, shape (3,): of the plan while there is one, then wings level."""
        if self._plan is not None and self.time < self._end:
            self.holding = False
            segment = int(np.searchsorted(self._starts, self.time + 1e-9, side="right")) - 1
            return self._plan[max(segment, 0)]
        if not self.holding:
            self.holding = True
            self.failsafes += 1
        level = np.array([0.0, -self.state[4] / LEVELLING_TIME, 0.0])
        return np.clip(level, self._lower, self._upper)

    def advance(self, duration: float) -> NDArray[np.float64]:
        """Fly on for ``duration`` [s] under held inputs and return the state, shape (6,)."""
        if duration <= 0.0:
            return self.state
        inputs = self.inputs().copy()
        parameters = self._parameters
        room = np.array([parameters.speed_min, parameters.speed_max]) - self.state[5]
        inputs[2] = np.clip(inputs[2], *(room / duration))
        self.state = vehicle.advance(self.state, inputs, duration)
        self.time += duration
        return self.state
