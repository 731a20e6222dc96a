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

"""What a flight leaves behind: the record from which metrics, figures and the report are made."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import relative_state, steady_inputs, tracking_error
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters

SLOWEST = 1e-6  # m/s, tolerance: a slower velocity has no direction


@dataclass(frozen=True)
class CommandCounts:
    """What the command link saw.

    Attributes:
        sent: Commands published by the controller.
        late: Commands that came more than half a control period after they were due.
        plan_reused: Commands taken from an earlier plan because no new one was available.
        failsafe: Flown without a plan: by the loiter law, or wings level, because the controller
            said so or the vehicle had come to the end of its plan.
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


class FlownMode(NamedTuple):
    """A fallback mode from a time on.

    Attributes:
        time: In [s] from the start.
        mode: What is flown.
        reason: Why it is none better, in words; empty if it is what was asked for.
    """

    time: float
    mode: FallbackMode
    reason: str = ""


class SensorNews(NamedTuple):
    """What became of a sensor.

    Attributes:
        time: In [s] from the start.
        sensor: Its name, e.g. ``airspeed``.
        state: ``used``, or why it is left out, in a word.
    """

    time: float
    sensor: str
    state: str


@dataclass(frozen=True)
class FlightLog:
    """Record of one flight.

    Attributes:
        config: Name of the configuration flown.
        duration: Length of the mission in [s].
        speed: Simulated over wall time [-]; 0 where the flight was not tied to wall time.
        model: Prediction model of the controller.
        plant: Name of the plant that was flown.
        orbit: Reference, the last one where it changed in flight.
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
        orbits: Times in [s] and the reference from each on, in order; the first also holds before.
            Empty where it is always ``orbit``.
        turn_rate: psi' at the times of the states as flown or measured, shape (n,), in [rad/s];
            None where it is to be taken from the headings.
        modes: Each mode that was flown and why, in order; the last one to the end. From a bag as
            the diagnostics tell it, about once a second. Empty where it is not recorded.
        tracking: What the controller flew by at the start, with the limits of the aircraft; None
            where it is not known.
        measured_bank: At the times of the states by the attitude, positive to the right, shape
            (n,), in [rad]; None where the source tells none.
        softened: Greatest factor by which a limit cycle made changes of an input weigh more
            [-]; 1 where there was none.
        sensors: When the controller left which sensor out or took it back, and why, in order.
        unusable: Messages that could not be read as what they are.
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
    orbits: tuple[tuple[float, Orbit], ...] = ()
    turn_rate: NDArray[np.float64] | None = None
    modes: tuple[FlownMode, ...] = ()
    tracking: TrackingParameters | None = None
    measured_bank: NDArray[np.float64] | None = None
    softened: float = 1.0
    sensors: tuple[SensorNews, ...] = ()
    unusable: int = 0

    @property
    def not_by_law(self) -> str:
        """That the guidance law answered none of the commands, and why, in words.

        Empty where it answered one, where none is flown, and where that is not recorded.
        """
        tracking, nominal = self.tracking, self.nominal
        if tracking is None or tracking.law == PREDICTIVE or nominal is None or nominal.any():
            return ""
        reasons = [each.reason for each in self.modes if each.mode is not FallbackMode.SILENCE]
        why = f": {reasons[0]}" if reasons else ""
        return f"the law answered none of {len(nominal)} commands{why}"

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
        relative, error = self.relative, np.empty((len(self.time), 5))
        for orbit, flown in self._spans:
            error[flown] = tracking_error(relative[flown], orbit)
        return error

    @property
    def radius(self) -> NDArray[np.float64]:
        """Horizontal distance that is asked for at the times of the states, shape (n,), in [m]."""
        range_, _, altitude, _, _ = self.reference.T
        return np.sqrt(range_**2 - altitude**2)

    @property
    def reference(self) -> NDArray[np.float64]:
        """State x_ss that is asked for at the times of the states, shape (n, 5)."""
        reference = np.empty((len(self.time), 5))
        for orbit, flown in self._spans:
            reference[flown] = orbit.steady_state
        return reference

    @property
    def bank(self) -> NDArray[np.float64]:
        """Bank by the attitude, else of the coordinated turn that is flown, right wing down.

        Shape (n,), in [rad].
        """
        if self.measured_bank is not None:
            return self.measured_bank
        _, _, _, heading, _, airspeed = self.vehicle.T
        turn_rate = self.turn_rate
        if turn_rate is None:
            turn_rate = np.zeros_like(heading)
            if len(heading) > 1:
                turn_rate = np.gradient(np.unwrap(heading), self.time)
        return np.asarray(bank_from_turn_rate(turn_rate, airspeed))

    @property
    def wind(self) -> NDArray[np.float64]:
        """Velocity of the air at the times of the states in ``map``, shape (n, 3), in [m/s].

        It is what velocity over ground and velocity through the air leave between them, with the
        noise of both.
        """
        through_air = np.array([velocity(state) for state in self.vehicle]).reshape(-1, 3)
        ground = self.ground_velocity
        return np.zeros_like(through_air) if ground is None else ground - through_air

    @property
    def drift(self) -> NDArray[np.float64]:
        """Velocity of the air relative to the target, shape (n, 3), in [m/s]."""
        return self.wind - (0.0 if self.target_velocity is None else self.target_velocity)

    def mode_at(self, time: float) -> FlownMode | None:
        """What is flown at a time; None before the first mode.

        Args:
            time: In [s] from the start.
        """
        index = bisect_right(self.modes, time, key=lambda flown: flown.time) - 1
        return self.modes[index] if index >= 0 else None

    @property
    def mode_spans(self) -> list[tuple[float, float, FlownMode]]:
        """Begin and end in [s] of each mode that was flown, in order."""
        end = float(self.time[-1]) if len(self.time) else self.duration
        ends = [*(flown.time for flown in self.modes[1:]), end]
        # Without a mode there is one end too many.
        return [(each.time, end, each) for each, end in zip(self.modes, ends, strict=False)]

    @property
    def _spans(self) -> Iterator[tuple[Orbit, slice]]:
        """Each reference, and which of the states it is of."""
        orbits = self.orbits or ((0.0, self.orbit),)
        begins = [0, *(int(np.searchsorted(self.time, time)) for time, _ in orbits[1:])]
        ends = [*begins[1:], len(self.time)]
        for (_, orbit), begin, end in zip(orbits, begins, ends, strict=True):
            yield orbit, slice(begin, end)
