"""The simulated aircraft: the vehicle (3) in moving air, behind an autopilot that flies plans."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.inner_loop import Channel, InnerLoop
from uav_tracking_mpc.simulation.lagged_flight import advance_lagged
from uav_tracking_mpc.simulation.wind import Wind

GRAVITY = 9.80665  # m/s^2
LEVELLING_TIME = 1.0  # s, in which wings-level flight takes the path angle out
LEAD_LIMIT = 1.0  # s, by which a plan may begin in the future


class Plant:
    """Vehicle and autopilot: flies the newest plan, then wings level.

    (3) moves it through the air, and the air moves over ground, which lies at z = 0: the airspeed
    is the autopilot's, so a gust shifts the vehicle and does not shake it.

    Args:
        parameters: Start, limits, inner loop, wind and sensors.

    Attributes:
        state: (x, y, z, psi, chi, v), shape (6,): position in ``map``; heading, path angle and
            magnitude of the velocity through the air.
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
        self._inner_loop = InnerLoop(parameters.rate_lag, parameters.dead_time)
        gusts, sensors = np.random.SeedSequence(parameters.seed).spawn(2)
        east, north, up = parameters.wind
        self._wind = Wind(
            (east, north, up),
            parameters.gust_intensity,
            gusts,
            heading=parameters.initial_heading,
            height=parameters.initial_position[2],
        )
        self._sensors = np.random.default_rng(sensors)

    @property
    def commanded(self) -> bool:
        """Whether a plan has ever arrived."""
        return self._plan is not None

    @property
    def rates(self) -> NDArray[np.float64]:
        """(u_psi, u_chi, u_v) flown now, shape (3,); zero before the first step."""
        return np.array([channel.rate for channel in self._inner_loop.channels])

    @property
    def wind(self) -> NDArray[np.float64]:
        """Velocity of the air now with its gusts, shape (3,), in ``map``, in [m/s]."""
        return self._wind.velocity

    @property
    def ground_velocity(self) -> NDArray[np.float64]:
        """Velocity through the air plus that of the air, shape (3,), in ``map``, in [m/s]."""
        return vehicle.velocity(self.state) + self._wind.velocity

    def measured(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """State, shape (6,), and ground velocity, shape (3,), as the sensors give them.

        Every call draws anew; without noise they are the truth.
        """
        parameters = self._parameters
        deviations = (
            *[parameters.position_noise] * 3,
            *[parameters.attitude_noise] * 2,
            parameters.airspeed_noise,
            *[parameters.velocity_noise] * 3,
        )
        state, ground_velocity = self.state.copy(), self.ground_velocity
        if any(deviations):
            noise = np.array(deviations) * self._sensors.standard_normal(9)
            state += noise[:6]
            state[3] = wrap_angle(state[3])
            state[4] = min(max(state[4], -0.5 * math.pi), 0.5 * math.pi)
            state[5] = max(state[5], 0.0)
            ground_velocity += noise[6:]
        return state, ground_velocity

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
        """Inputs that the autopilot commands now, shape (3,): the plan's, or wings level."""
        if self._plan is not None and self.time < self._end:
            self.holding = False
            segment = int(np.searchsorted(self._starts, self.time + 1e-9, side="right")) - 1
            inputs = self._plan[max(segment, 0)].copy()
        else:
            if not self.holding:
                self.holding = True
                self.failsafes += 1
            level = -float(self.state[4]) / LEVELLING_TIME
            limit = self._parameters.pitch_rate_max
            inputs = np.array([0.0, min(max(level, -limit), limit), 0.0])
        # Coordinated turn: tan(bank) = v u_psi / g.
        turning = GRAVITY * math.tan(self._parameters.bank_max) / max(float(self.state[5]), 1e-6)
        inputs[0] = min(max(float(inputs[0]), -turning), turning)
        return inputs

    def advance(self, duration: float) -> NDArray[np.float64]:
        """Fly on for ``duration`` [s] under a held command and return the state, shape (6,)."""
        if duration <= 0.0:
            return self.state
        self._inner_loop.command(self.time, self.inputs().tolist())
        before, flown = self.state.tolist(), 0.0
        while flown < duration:
            change = self._inner_loop.unchanged_until(self.time + flown) - self.time
            until = min(change, duration)
            self._fly(until - flown)
            flown = until
        drift = self._wind.advance(
            duration,
            airspeed=before[5],
            height=before[2],
            heading=before[3],
            turn=math.remainder(float(self.state[3]) - before[3], 2.0 * math.pi),
        )
        self.state[:3] += drift
        self.time += duration
        return self.state

    def _fly(self, duration: float) -> None:
        """Fly through the air while the inner loop's channels follow the same commands."""
        turn, climb, engine = self._inner_loop.channels
        slowest, fastest = self._parameters.speed_min, self._parameters.speed_max
        gained, speed = engine.after(duration)[1], float(self.state[5])
        allowed = min(max(gained, slowest - speed), fastest - speed)
        acceleration = engine
        if gained != allowed:  # the limit is reached at the end, whatever the engine does
            acceleration = Channel(lag=0.0, dead_time=0.0)
            acceleration.wanted = allowed / duration
        channels = (turn, climb, acceleration)
        if any(channel.lag for channel in channels):
            self.state = np.array(advance_lagged(self.state.tolist(), channels, duration))
        else:
            inputs = [channel.wanted for channel in channels]
            self.state = vehicle.advance(self.state, inputs, duration)
            for channel in channels:
                channel.rate = channel.wanted
        if acceleration is not engine:
            engine.rate = 0.0
