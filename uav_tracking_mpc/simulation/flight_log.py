"""What a flight leaves behind: the record from which metrics, figures and the report are made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import relative_state, steady_inputs, tracking_error

SLOWEST = 1e-6  # m/s; a slower velocity has no direction


@dataclass(frozen=True)
class CommandCounts:
    """What the command link saw.

    Attributes:
        sent: Commands published by the controller.
        late: Commands that came more than half a control period after they were due.
        plan_reused: Commands taken from an earlier plan because no new one was available.
        failsafe: Wings level, commanded by the controller or because the vehicle ran out of plan.
    """

    sent: int = 0
    late: int = 0
    plan_reused: int = 0
    failsafe: int = 0


@dataclass(frozen=True)
class Latency:
    """Wall time from the stamp of a state to the publishing of its command.

    Attributes:
        median: In [us].
        p99: 99th percentile in [us].
        max: In [us].
    """

    median: float
    p99: float
    max: float


@dataclass(frozen=True)
class LinkFigures:
    """What the link to a real autopilot measured.

    Attributes:
        dialect: Of the autopilot.
        rate: Of the states in [Hz].
        latency: From telemetry in to the set-point that answers it, median, in [ms].
        latency_p99: 99th percentile of it in [ms].
        lost: Messages of the autopilot that never came.
        refused: Commands that the link or the autopilot refused.
    """

    dialect: str
    rate: float
    latency: float
    latency_p99: float
    lost: int
    refused: int


@dataclass(frozen=True)
class FlightLog:
    """Record of one flight.

    Attributes:
        config: Name of the configuration flown.
        duration: Length of the mission in [s].
        speed: Simulated over wall time [-]; 0 where the flight was not tied to wall time.
        model: Prediction model of the controller.
        plant: Name of the plant that was flown.
        orbit: Reference.
        input_lower: Lower bounds of (u_psi, u_chi, u_v), shape (3,), in [rad/s], [rad/s], [m/s^2].
        input_upper: Upper bounds, shape (3,), in the same units.
        time: Times of the states in [s] from the start, shape (n,).
        vehicle: (x, y, z, psi, chi, v) at these times, shape (n, 6): angles and speed are those of
            the velocity through the air.
        target: True target position at these times, shape (n, 3).
        command_time: Times of the commands in [s] from the start, shape (m,).
        inputs: (u_psi, u_chi, u_v) commanded, shape (m, 3).
        cost: Optimal cost V_N at each command, nan where there was none, shape (m,).
        solve_time: Wall time of each solve in [s], shape (m,).
        solver: Name of the solver.
        failures: Solves that did not converge.
        commands: Counts of the command link.
        latency: Set for flights with real nodes only.
        ground_velocity: Velocity over ground at the times of the states in ``map``, shape (n, 3);
            None where the air stands still.
        target_velocity: True velocity of the target at these times, shape (n, 3), in [m/s]; None
            where it stands.
        link: Set for flights with a real autopilot only.
        nominal: Whether each command was what was asked for, an optimal plan or the answer of the
            guidance law, shape (m,); None where that is not recorded.
    """

    config: str
    duration: float
    speed: float
    model: str
    plant: str
    orbit: Orbit
    input_lower: NDArray[np.float64]
    input_upper: NDArray[np.float64]
    time: NDArray[np.float64]
    vehicle: NDArray[np.float64]
    target: NDArray[np.float64]
    command_time: NDArray[np.float64]
    inputs: NDArray[np.float64]
    cost: NDArray[np.float64]
    solve_time: NDArray[np.float64]
    solver: str
    failures: int = 0
    commands: CommandCounts = CommandCounts()
    latency: Latency | None = None
    ground_velocity: NDArray[np.float64] | None = None
    target_velocity: NDArray[np.float64] | None = None
    nominal: NDArray[np.bool_] | None = None
    link: LinkFigures | None = None

    @property
    def steady_inputs(self) -> NDArray[np.float64]:
        """u_ss of the prediction model, shape (3,), in [rad/s], [rad/s] and [m/s^2]."""
        return steady_inputs(self.model, self.orbit)

    @property
    def course(self) -> NDArray[np.float64]:
        """Direction of the horizontal velocity relative to the target, shape (n,), in [rad].

        It is the heading where air and target stand still, and where there is no such velocity.
        """
        _, _, _, heading, _, _ = self.vehicle.T
        if self.ground_velocity is None:
            return heading
        target = 0.0 if self.target_velocity is None else self.target_velocity
        east, north, _ = (self.ground_velocity - target).T
        return np.where(np.hypot(east, north) > SLOWEST, np.arctan2(north, east), heading)

    @property
    def relative(self) -> NDArray[np.float64]:
        """(r, theta, z, chi, v) at the times of the states, shape (n, 5).

        theta is the bearing of :attr:`course`: where the vehicle moves, not where its nose points,
        tells whether it circles the target.
        """
        x, y, z, _, path_angle, speed = self.vehicle.T
        vehicles = np.column_stack([x, y, z, self.course, path_angle, speed])
        return np.array(
            [
                relative_state(vehicle, target)
                for vehicle, target in zip(vehicles, self.target, strict=True)
            ]
        ).reshape(-1, 5)

    @property
    def error(self) -> NDArray[np.float64]:
        """Tracking error x = xbar - x_ss at the times of the states, shape (n, 5)."""
        return tracking_error(self.relative, self.orbit)
