"""What to fly now: the predictive controller on its ladder; always finite, always inside limits."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.direction import NEAREST, nearest_direction
from uav_tracking_mpc.control.fallback import Change, Footing, Ladder, Rung
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Formulation, Plan
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, TrackingParameters

LEVELLING_TIME = 1.0  # s, in which wings-level flight takes the path angle out
# Compiled in, or part of what is claimed of the controller.
FIXED = (
    "horizon", "horizon_step", "terminal_constraint", "limits", "vehicle_model", "model", "scheme",
    "solver", "limit_penalty", "certificate", "autostart",
)  # fmt: skip
BLEND_TIME = 0.5  # s, in which the command moves over from one kind of guidance to another


@dataclass(frozen=True)
class Command:
    """What to fly now and, should nothing follow, after that.

    Attributes:
        inputs: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3), inside the limits; held
            in between.
        step: In [s].
        rung: Where it comes from.
        reason: Why it is not optimal; empty if it is.
        change: The step on the ladder that led there, if there was one.
        orbit: What is flown.
        plan: What the controller answered; None if it was not asked.
    """

    inputs: NDArray[np.float64]
    step: float
    rung: Rung
    reason: str
    change: Change | None
    orbit: Orbit
    plan: Plan | None

    @property
    def solution(self) -> Solution | None:
        """What the solver said."""
        return None if self.plan is None else self.plan.solution


@dataclass(frozen=True)
class Outlook:
    """What a command is computed from.

    Attributes:
        situation: When the command takes effect.
        forecast: From then on.
        target_fresh: Whether the target's position is young enough to plan with.
    """

    situation: Situation
    forecast: Forecast
    target_fresh: bool = True


def formulation_of(parameters: TrackingParameters) -> Formulation:
    """The formulation that the parameters ask for; only this one is loaded."""
    if parameters.terminal_constraint == ARTIFICIAL_ORBIT:
        from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation

        return FlightFormulation(parameters)
    from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation

    return PaperFormulation(parameters)


class Pilot:
    """Commands from situations.

    Args:
        parameters: What to fly and how.
        formulation: Of these parameters; made from them by default.

    Attributes:
        ladder: Where the command comes from, with counts.
        orbit: What is flown, with the direction chosen.
    """

    def __init__(
        self, parameters: TrackingParameters, formulation: Formulation | None = None
    ) -> None:
        self.formulation = formulation or formulation_of(parameters)
        self.ladder = Ladder()
        self.reset()
        self._take(parameters)

    def reset(self) -> None:
        """Forget every plan."""
        self.formulation.reset()
        self._direction: str | None = None
        self._plan: Plan | None = None
        self._plan_time = self._blend_time = 0.0
        self._last_time: float | None = None
        self._offset = np.zeros(3)
        self._renewed = False
        self._sent: NDArray[np.float64] | None = None
        self._sent_rung = Rung.SILENCE

    def check(self, parameters: TrackingParameters) -> None:
        """Whether other parameters can be flown by from now on.

        Raises:
            ParameterError: They can only be taken at the start.
        """
        for name in FIXED:
            before, after = getattr(self.parameters, name), getattr(parameters, name)
            if before != after:
                raise ParameterError(
                    f"parameter '{name}' is {after!r}, must stay {before!r} while the controller "
                    "is configured"
                )
        self.formulation.check(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Fly by other parameters from now on; the present plan is the next one's start.

        Raises:
            ParameterError: As of :meth:`check`; nothing has changed.
        """
        self.check(parameters)
        self.formulation.change(parameters)
        if parameters.direction != self.parameters.direction:
            self._direction = None
        self._renewed = True
        self._take(parameters)

    def _take(self, parameters: TrackingParameters) -> None:
        self.parameters = parameters
        self.envelope = parameters.envelope
        self._lower, self._upper = parameters.input_lower, parameters.input_upper
        direction = self._direction or parameters.orbit.direction  # the nearest one, chosen before
        self._choose(dataclasses.replace(parameters.orbit, direction=direction))

    def _choose(self, orbit: Orbit) -> None:
        self.orbit = orbit
        self._fallback = VectorField(orbit, self.envelope)

    def step(self, time: float, outlook: Outlook) -> Command:
        """Command for a situation.

        Args:
            time: Of the state that the command answers, in [s].
            outlook: Situation and forecast; values that are not finite are survived.
        """
        situation = outlook.situation
        orbit = self._oriented(situation)
        plan, trouble = self._solve(time, outlook, orbit)
        solution = None if plan is None else plan.solution
        left = self._remaining(time)
        change = self.ladder.step(
            Footing(True, True, outlook.target_fresh, solution, left is not None, trouble)
        )
        rung = self.ladder.rung
        if rung is Rung.EARLIER_PLAN and left is not None:
            inputs, step = left, self.formulation.step
        elif rung.planned and plan is not None:
            self._plan, self._plan_time = plan, time
            inputs, step = plan.inputs, plan.step
        else:
            inputs, step = self._loiter(situation)[np.newaxis], LEVELLING_TIME
        return self._command(time, inputs, step, situation.vehicle, change, plan)

    def hold(self, time: float, vehicle: NDArray[np.float64], trouble: str) -> Command:
        """Wings level at the present speed: there is no target to fly about."""
        change = self.ladder.step(Footing(True, False, False, None, False, trouble))
        level = np.array([[0.0, -float(vehicle[4]) / LEVELLING_TIME, 0.0]])
        return self._command(time, level, LEVELLING_TIME, vehicle, change, None)

    def fall_silent(self, trouble: str) -> Change | None:
        """No command can be sent; the change, if this is news."""
        self._sent = None
        return self.ladder.step(Footing(False, False, False, None, False, trouble))

    def _oriented(self, situation: Situation) -> Orbit:
        """The orbit in its direction; the nearest one is chosen once, with hysteresis."""
        if self.parameters.direction != NEAREST:
            return self.orbit
        self._direction = nearest_direction(situation, self._direction)
        if self._direction != self.orbit.direction:
            self._choose(dataclasses.replace(self.orbit, direction=self._direction))
        return self.orbit

    def _solve(self, time: float, outlook: Outlook, orbit: Orbit) -> tuple[Plan | None, str]:
        """The controller's answer, or what kept it from one."""
        if not outlook.target_fresh:
            return None, ""
        elapsed = None if self._last_time is None else max(0.0, time - self._last_time)
        self._last_time = time
        try:
            plan = self.formulation.solve(outlook.situation, outlook.forecast, orbit, elapsed)
        except (ArithmeticError, RuntimeError, ValueError) as error:
            return None, f"the controller failed: {error}"
        if not np.all(np.isfinite(plan.inputs)):
            return None, f"the plan is not finite: {plan.solution.message}"
        return plan, ""

    def _loiter(self, situation: Situation) -> NDArray[np.float64]:
        """The loiter law's inputs; straight on where the situation is not finite."""
        try:
            return self._fallback.inputs(situation)
        except (ArithmeticError, ValueError):
            return np.zeros(3)

    def _remaining(self, time: float) -> NDArray[np.float64] | None:
        """What is left of the last plan, if it is young enough to be flown."""
        if self._plan is None or not 0.0 <= time - self._plan_time <= self.parameters.plan_age_max:
            return None
        flown = int((time - self._plan_time) / self._plan.step)
        remaining = self._plan.inputs[flown:]
        return remaining if len(remaining) else None

    def _command(
        self,
        time: float,
        inputs: NDArray[np.float64],
        step: float,
        vehicle: NDArray[np.float64],
        change: Change | None,
        plan: Plan | None,
    ) -> Command:
        ladder = self.ladder
        airspeed = float(vehicle[5])
        inside = self._inside(inputs, airspeed)
        inputs = self._blended(time, inside, step)
        if inputs is not inside:
            inputs = self._inside(inputs, airspeed)
        self._sent, self._sent_rung = inputs[0], ladder.rung
        return Command(inputs, step, ladder.rung, ladder.reason, change, self.orbit, plan)

    def _blended(
        self, time: float, inputs: NDArray[np.float64], step: float
    ) -> NDArray[np.float64]:
        """Where plan, law and level flight take over from each other, their difference fades.

        So it does where other parameters take over: another orbit would begin at the bank limit.
        """
        before, rung = self._sent_rung, self.ladder.rung
        if self._sent is None:
            self._offset = np.zeros(3)
        elif self._renewed or (rung is not before and not (rung.planned and before.planned)):
            self._offset, self._blend_time = self._sent - inputs[0], time
        self._renewed = False
        if not 0.0 <= time - self._blend_time < BLEND_TIME or not np.any(self._offset):
            return inputs
        ahead = time - self._blend_time + step * np.arange(len(inputs))
        share = np.clip(1.0 - ahead / BLEND_TIME, 0.0, 1.0)
        return inputs + share[:, np.newaxis] * self._offset

    def _inside(self, inputs: NDArray[np.float64], airspeed: float) -> NDArray[np.float64]:
        """Inputs inside their limits; what is not finite becomes 0."""
        if np.isfinite(airspeed):
            self._upper[0] = self.envelope.turn_rate_max(airspeed)
            self._lower[0] = -self._upper[0]
        finite = np.isfinite(inputs)
        if not finite.all():
            inputs = np.where(finite, inputs, 0.0)
        return np.minimum(np.maximum(inputs, self._lower), self._upper)
