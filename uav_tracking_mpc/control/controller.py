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

"""The whole control step, from a measurement to a command; knows nothing of ROS.

A step judges the measurement, estimates where the aircraft will be when the command takes effect,
solves the optimal control problem from there, or falls back. Times are in [s] of stamps' clock::

    controller = Controller(load_configuration("small_uav").controller)
    controller.see_target(stamp, position)
    command = controller.step(measurement, now=clock())  # None while there is nothing to answer
    controller.change(range=350.0)                       # as a whole, or refused in words
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.control.adaptation import ResponseAdaptation
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.command_shaping import CommandShaper
from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.fallback import (
    OWN_SOLVE,
    Available,
    FallbackMode,
    ModeSelector,
    PlanMemory,
    choose,
)
from uav_tracking_mpc.control.guidance import (
    ask_law,
    formulation_of,
    law_about,
    law_inputs,
    law_of,
    nearest_direction,
)
from uav_tracking_mpc.control.pace import Pace
from uav_tracking_mpc.control.watches import AirspeedMargin, AirspeedWatch, OrbitShortfall
from uav_tracking_mpc.dynamics.orbit import orbit_about
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.navigator import Estimate, Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.estimation.state_gate import StateGate, Verdict
from uav_tracking_mpc.formulation.formulation import Formulation, Plan
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.parameters.specification import ParameterError, changed, refuse_fixed
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, NEAREST, TrackingParameters

LEVELLING_TIME = 1.0  # s, in which wings-level flight takes the path angle out
LASTS = 0.9  # -, share of the control period for which the first input of a plan is held at least
QUARTER_TURN = 0.8  # -, share of a quarter turn, from towards the target to about it, in a plan


class Controller:
    """Answers measurements with commands that are always finite and inside the limits.

    Args:
        parameters: What to fly and how. Measurements must come more often than ``state_timeout``.
        formulation: Of these parameters; made from them by default.
        stopwatch: Clock in [s] of how long answers take; constant where a simulation waits for one.
            The solver keeps to its ``solve_time_max`` of wall time all the same.

    Attributes:
        formulation: The optimal control problem; None where a guidance law is flown.
        orbit: What is flown, with the direction chosen.
        modes: What the command comes from, with counts.
        navigator: What is known of aircraft, air and target.
        response: How the aircraft answers commands, as learnt and as flown by.
        rate: When a command is due, and whether the control rate is kept.
        flying: Whether a command has been sent since the start or the last reset.
        drift: c when the latest command was computed, shape (3,), in [m/s].
        events: What has happened since it was last asked.

    Raises:
        ParameterError: The parameters cannot be flown.
    """

    def __init__(
        self,
        parameters: TrackingParameters,
        formulation: Formulation | None = None,
        stopwatch: Callable[[], float] = time.perf_counter,
    ) -> None:
        if not isinstance(parameters, TrackingParameters):
            kind = type(parameters).__name__
            words = "must be TrackingParameters, as load_configuration(...).controller"
            raise ParameterError(f"parameters are a {kind}, {words}")
        self.parameters, self._stopwatch = parameters, stopwatch
        self._law_class = law_of(parameters)
        if self._law_class is not None:
            ask_law(self._law_class, parameters)
        self.formulation = formulation or formulation_of(parameters)
        self.navigator, self.modes = Navigator(parameters), ModeSelector()
        self.rate = Pace(parameters.control_rate)
        self._gate = StateGate(parameters.state_timeout, parameters.air_estimation)
        self.events = EventLog()
        self.response = ResponseAdaptation(parameters, self.events)
        self._plan, self._shortfall = PlanMemory(), OrbitShortfall(self.events)
        self._airspeed = AirspeedWatch(self.events)
        self._margin, self._flown = AirspeedMargin(parameters, self.events), parameters
        self._shaper = CommandShaper(parameters, self.events)
        self.reset()
        self._choose()
        self._advise()

    def _advise(self) -> None:
        """Warn of plans that end before they can be on an orbit, as those of a fast aircraft."""
        asked = self.parameters
        if self.formulation is None or asked.terminal_constraint != ARTIFICIAL_ORBIT:
            return
        lasts = asked.horizon * asked.horizon_step
        quarter = 0.5 * math.pi / asked.envelope.turn_rate_max(asked.airspeed)
        if lasts < QUARTER_TURN * quarter:
            words = f"plans last {lasts:.3g} s, but a quarter turn takes {quarter:.3g} s"
            remedy = "raise horizon_step, or the loiter law flies most of the way to the orbit"
            self.events.add(Level.WARNING, f"{words}: {remedy}")

    def reset(self) -> None:
        """Forget aircraft, air, target, plans and commands; counts stay."""
        self._gate = StateGate(self._gate.timeout, self._gate.checked)
        self.flying = self.navigator.claimed = False
        softened = bool(np.any(self.response.softening.factors > 1.0))
        self._respond(self.response.reset())
        if softened and self.formulation is not None:
            self.formulation.soften(self.response.softening.factors)
        self.navigator.reset()
        self._forget()

    def _forget(self) -> None:
        """Forget plans, commands and solves: of a place or a flight that is no more."""
        for part in (self.rate, self._shaper, self._plan, self._shortfall, self._airspeed):
            part.reset()
        self.response.interrupt()
        if self.formulation is not None:
            self.formulation.reset()
        self._direction: str | None = self._direction if self.navigator.claimed else None
        self._solve_time: float | None = None
        self._late = False
        self.drift = np.zeros(3)

    @property
    def state_time(self) -> float | None:
        """Stamp of the newest measurement that was believed in [s]; None before the first."""
        return None if self._gate.newest is None else self._gate.newest.stamp

    def check(self, parameters: TrackingParameters) -> None:
        """Whether other parameters can be taken now.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: A fixed one differs, or the orbit cannot be flown, by the law that is
                asked for or, unless that is so of the present one, in the present drift.
        """
        refuse_fixed(self.parameters, parameters)
        if self.formulation is not None:
            self.formulation.check(parameters)
        if self._law_class is not None:
            ask_law(self._law_class, parameters)
        refusal, flown = (
            asked.envelope.refusal(asked.orbit, self.drift, self.navigator.target.height)
            for asked in (parameters, self.parameters)
        )
        if refusal and refusal != flown:  # else it is refused already, whatever changes
            raise ParameterError(f"parameters 'range', 'altitude', 'airspeed': {refusal}")

    def change(self, **values: Any) -> None:
        """Fly by other parameters from now on; the present plan is the next one's start.

        Args:
            values: Parameters by name, in the units of :class:`TrackingParameters`.

        Raises:
            ParameterError: Unknown, not allowed, or as of ``check``; nothing has changed.
        """
        parameters = changed(self.parameters, values)
        self.check(parameters)
        self.navigator.change(parameters)
        if parameters.direction != self.parameters.direction:
            self._direction = None
        self.rate.rate, self._gate.timeout = parameters.control_rate, parameters.state_timeout
        self.parameters = parameters
        self._margin.forget(parameters)
        self._fly_by(parameters, self.response.tell(parameters))
        self.events.add(Level.INFO, f"from now on {self.orbit.in_short}, {parameters.direction}")
        self._advise()

    def _respond(self, response: Response | None) -> None:
        """Predict with another response from now on; with None as before."""
        if response is not None:
            self.navigator.respond(response)
            if self.formulation is not None:
                self.formulation.respond(response)

    def _keep_margin(self) -> None:
        """Fly within what the aircraft gives, and no slower than is safe by what is known."""
        flown = self._margin.flown(self.response.limited, *self.navigator.airspeed_uncertainty)
        if flown is None:
            return
        before = self._flown
        try:
            self._fly_by(flown, self.response.flown)
        except Exception as error:  # of a law or limit of somebody's, asked about what was told
            self._fly_by(before, self.response.flown)
            self.events.add(Level.WARNING, f"the orbit stays as it was: {error}")

    def _fly_by(self, flown: TrackingParameters, response: Response | None) -> None:
        self._flown = flown
        if self.formulation is not None:
            self.formulation.change(flown)
        self._respond(response)
        self._shaper.change(flown)
        self._choose()

    def _choose(self) -> None:
        """Fly the orbit that is asked for, in the nearest direction once that is chosen."""
        orbit, law = self._flown.orbit, self._law_class
        self.orbit = dataclasses.replace(orbit, direction=self._direction or orbit.direction)
        self._loiter = law_about(VectorField, self.orbit, self._flown)
        self._law = None if law is None else law_about(law, self.orbit, self._flown)

    def see_air(self, stamp: float, airspeed: float) -> None:
        """Take in an airspeed that comes beside the measurements: see :meth:`AirData.see`.

        Args:
            stamp: When it was measured in [s].
            airspeed: v in [m/s].
        """
        self.navigator.air.see(stamp, airspeed)

    def see_target(
        self,
        stamp: float,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        *,
        now: float = math.nan,
    ) -> bool:
        """Take in a measurement of the target: see :meth:`TargetFilter.update`.

        Args:
            stamp: When it was measured in [s].
            position: In ``map``, shape (3,), in [m].
            velocity: In ``map``, shape (3,), in [m/s]; None if it is not known.
            covariance: Of position, shape (3, 3), or of position and velocity, shape (6, 6), in
                SI units; None if it is not known.
            now: Time at the call in [s], by the clock of the stamps; not a number if it is unknown.

        Raises:
            MeasurementError: Not finite, not of its shape, or stamped by another clock.
        """
        known, limit = self.navigator.target.time, self.parameters.target_timeout
        self._gate.check_target(stamp, known, limit, now)
        return self.navigator.see_target(stamp, position, velocity, covariance)

    def see_state(self, measurement: Measurement, now: float = math.nan) -> None:
        """Take note of a measurement that is not to be answered.

        Args:
            measurement: Of the aircraft.
            now: Time at the call in [s], by the clock of the stamps; not a number if it is unknown.
        """
        self._believe(measurement, now)

    def step(self, measurement: Measurement, now: float) -> Command | None:
        """Answer a measurement.

        Args:
            measurement: Of the aircraft.
            now: Time at the call in [s], by the clock of the stamps.

        Returns:
            None while no command is due, the measurement is doubted or late, no target seen, or no
            position for too long.
        """
        begin, stamp = self._stopwatch(), measurement.stamp
        believed = self._believe(measurement, now)
        if believed is None:
            return self._go_on(stamp) if self._gate.hangs(measurement) else None
        measurement, vehicle = believed
        self.rate.state(stamp)
        target = self.navigator.target
        if target.time is not None and target.time - stamp > self.parameters.target_timeout:
            target.reset()  # its stamp lies ahead of the state's: the clock was set back
        if not self.flying and (target.time is None or self.navigator.air.awaited):
            missing = "no target position" if target.time is None else "no airspeed yet"
            self._select(Available(state=False, trouble=missing))
            return None
        if not self.rate.due(stamp):
            return None
        if not self.flying:
            self.navigator.begin(now - stamp)
        self._respond(self.response.follow(stamp))
        factors = self.response.soften(stamp)
        if factors is not None and self.formulation is not None:
            self.formulation.soften(factors)
        self._keep_margin()
        command = self._answer(measurement, vehicle)
        if command is None:
            return None
        taken = self._stopwatch() - begin
        if taken > self.parameters.state_timeout:
            words = f"vehicle state: answered only after {taken:.3f} s: {OWN_SOLVE}"
            self.events.add(Level.REFUSAL, words)
            self.modes.counts[command.mode] -= 1  # it is not sent, and nothing of it stays
            self._plan.reset()
            self._silence(OWN_SOLVE)
            return None
        # An age below 0, as by a sender's clock that is ahead, counts as 0.
        delay = min(max(0.0, now - stamp), self.parameters.state_timeout) + taken
        self._tell_lateness(now - stamp)
        known = target.time is not None
        forced = math.hypot(*target.track.state[2, :2].tolist()) if known else 0.0
        flown = self.response.commanded(stamp, delay, command.inputs, command.step, forced)
        self.navigator.commanded(stamp, delay, flown, command.step)
        self.flying = True
        self.rate.sent(stamp)
        return command

    def _tell_lateness(self, late: float) -> None:
        """Warn of states that are older than is counted on, once until they are half as old."""
        most = self.parameters.state_timeout
        if late > most and not self._late:
            words = f"vehicle state: {late:.2f} s late, of which state_timeout counts {most:g} s"
            self.events.add(Level.WARNING, f"{words}: raise it, or do the clocks agree?")
        self._late = late > (0.5 * most if self._late else most)

    def engage(self, engaged: bool) -> None:
        """Say whether the aircraft flies the commands; while not, nothing is learnt from them.

        Args:
            engaged: Whether it does; so at the start.
        """
        self.navigator.engage(engaged)
        self.response.engage(engaged)

    def fall_silent(self, reason: str) -> None:
        """Send nothing: the vehicle flies its plan to the end, then holds.

        Args:
            reason: Why, in words.
        """
        self._gate.lost = True  # what is stamped later is not ahead of the aircraft
        self.rate.reset()
        self._silence(reason)

    def _silence(self, reason: str) -> None:
        self._shaper.pause()
        self._select(Available(state=False, trouble=reason))

    def _believe(
        self, measurement: Measurement, now: float
    ) -> tuple[Measurement, NDArray[np.float64]] | None:
        """See :meth:`Navigator.see_state`; None if the measurement is not to be used."""
        before, verdict = self.state_time, self._gate.judge(measurement, now)
        reason = f"vehicle state: {self._gate.reason}"
        if verdict is Verdict.DOUBT:
            self.events.add(Level.REFUSAL, f"{reason}; used if the next ones agree")
        if verdict is Verdict.RESTART:
            self.events.add(Level.WARNING, f"{reason}, starting anew")
            if before is not None and measurement.stamp < before:
                self.navigator.reset()  # target and airspeed were seen in a time that is no more
            else:
                self.navigator.begin_anew()
            self._forget()
        if verdict not in (Verdict.USE, Verdict.RESTART):
            return None
        measurement, vehicle = self.navigator.see_state(measurement)
        known, gusts = self.navigator.airspeed_known, self.navigator.gusts
        self.response.see(measurement, vehicle, known, gusts, self.navigator.air.bank_lost)
        return measurement, vehicle

    def _go_on(self, stamp: float) -> Command | None:
        """The latest plan, while states only repeat themselves; None once it is too old."""
        left = self._plan.remaining(stamp, self.parameters.plan_age_max)
        if left is None or not self.rate.due(stamp):
            return None
        self._select(Available(plan_left=True, trouble="the vehicle state repeats itself"))
        self.rate.sent(stamp)
        return self._command(stamp, left, self.navigator.airspeed, None, None)

    def _answer(self, measurement: Measurement, vehicle: NDArray[np.float64]) -> Command | None:
        """Command for a measurement that is believed and due; None where the position is lost."""
        stamp, seen = measurement.stamp, self.navigator.target.time
        try:
            estimate = self.navigator.estimate(measurement, vehicle)
        except (ArithmeticError, ValueError) as error:
            # No measurement should make the navigation fail; the aircraft is not lost over it.
            trouble = str(error) if seen is None else f"the navigation failed: {error}"
            return self._hold(stamp, vehicle, trouble)
        for words in self.navigator.complaints():
            self.events.add(Level.WARNING, words)
        if self.navigator.lost:
            self.rate.reset()
            self._silence("no position for so long that none is known")
            return None
        self.drift = estimate.present.drift
        if self.navigator.engaged:
            self._airspeed.see(stamp, estimate.present.airspeed, self.parameters)
        else:  # on the ground, or in the hands of a pilot, it may be as slow as it likes
            self._airspeed.reset()
        fresh = seen is not None and stamp - seen <= self.parameters.target_timeout
        return self._fly(stamp, estimate, fresh)

    def _fly(self, stamp: float, estimate: Estimate, target_fresh: bool = True) -> Command:
        """Command for an estimate; values that are not finite are survived."""
        self._orient(estimate.effect)
        plan: Plan | None = None
        by_law, trouble = None, ""
        if target_fresh and self._law is not None:
            by_law, trouble = law_inputs(self._law, estimate.present)
        elif target_fresh and self.formulation is not None:
            elapsed = None if self._solve_time is None else max(0.0, stamp - self._solve_time)
            self._solve_time = stamp
            where = estimate.effect, estimate.forecast, self.orbit
            try:
                plan = self.formulation.solve(*where, elapsed)
            except Exception as error:  # whatever a limit or model of somebody's raises
                trouble = f"the controller failed: {error}"
            if plan is not None and not math.isfinite(np.vdot(plan.inputs, plan.inputs)):
                trouble, plan = f"the plan is not finite: {plan.solution.message}", None
        left = self._plan.remaining(stamp, self.parameters.plan_age_max)
        solution = None if plan is None else plan.solution
        there = left is not None, by_law is not None
        available = Available(True, True, target_fresh, solution, *there, trouble)
        if choose(available)[0] is FallbackMode.LOITER:
            by_law, failed = law_inputs(self._loiter, estimate.effect)
            if by_law is None:
                return self._hold(stamp, estimate.effect.vehicle, failed)
        mode = self._select(available)
        if mode is FallbackMode.EARLIER_PLAN and left is not None:
            segments = left
        elif mode.planned and plan is not None:
            self._plan.keep(plan, stamp)
            self._shortfall.see(stamp, plan, self.orbit)
            segments = plan.inputs, plan.step
        else:
            assert by_law is not None
            segments = by_law, LEVELLING_TIME
        airspeed = max(estimate.effect.airspeed, self.navigator.airspeed)  # that lags behind
        return self._command(stamp, segments, airspeed, plan, estimate.present)

    def _hold(self, stamp: float, vehicle: NDArray[np.float64], trouble: str) -> Command:
        """Wings level at the present speed: there is no target to fly about."""
        self._select(Available(target=False, target_fresh=False, trouble=trouble))
        _, _, _, _, path_angle, airspeed = vehicle.tolist()
        level = np.array([[0.0, -path_angle / LEVELLING_TIME, 0.0]])
        return self._command(stamp, (level, LEVELLING_TIME), airspeed, None, None)

    def _orient(self, situation: Situation) -> None:
        """Choose the nearest direction, with hysteresis; it is kept while somebody has engaged."""
        if self.parameters.direction == NEAREST:
            self._direction = nearest_direction(situation, self._direction, self.navigator.claimed)
            if self._direction != self.orbit.direction:
                self._choose()

    def _command(
        self,
        stamp: float,
        told: tuple[NDArray[np.float64], float],  # inputs, shape (n, 3), and length of each [s]
        airspeed: float,
        plan: Plan | None,
        now: Situation | None,
    ) -> Command:
        (inputs, step), mode, reason = told, self.modes.mode, self.modes.reason
        # Segments count from the stamp: the first input lasts until the next command is there, or
        # half of its time where commands are that rare.
        until = self.navigator.latency + min(LASTS / self.parameters.control_rate, 0.5 * step)
        late = min(math.ceil(until / step), len(inputs)) - 1
        if late:
            inputs = np.vstack([*[inputs[:1]] * late, inputs[: len(inputs) - late]])
        inputs, air = inputs / self.response.flown.gains, self.navigator.air
        seen = airspeed, mode, air.surplus, now, air.too_fast
        inputs = self._shaper.shape(stamp, inputs, step, *seen)
        inputs = self._shaper.excitation.added(stamp, inputs, mode, self.orbit, now)
        flown = None
        if now is not None:  # the drift is the wind less the target's velocity
            ends = self._plan.orbit if mode.planned else None
            speed = max(0.0, now.airspeed)  # in this order 0 for no number
            flown = orbit_about(
                now.target, self.navigator.wind - now.drift, self.orbit, ends, speed, air.surplus
            )
        return Command(stamp, inputs, step, mode, reason, self.orbit, plan, now, flown)

    def _select(self, available: Available) -> FallbackMode:
        """Choose the mode and report its change."""
        if change := self.modes.select(available):
            self.events.add(Level.MODE, change)
        return self.modes.mode
