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

"""Random walks of a flight: whatever happens, commands come on time, are sound, and lead there."""

import math
from dataclasses import fields

import numpy as np
import pytest
import small_uav
from controller_cases import FLIGHT, Faulty, limits
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule

from uav_tracking_mpc.control.command_shaping import FADE_TIME
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.solver import Status
from uav_tracking_mpc.parameters.specification import ParameterError, specifications
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop

RATE = "nmpc_controller.control_rate=10.0"  # of states that come at 20 Hz
CONFIGURATION = load_configuration("small_uav", [small_uav.PATIENT, RATE])
LEFT = math.exp(-3.0)  # of a jump of what is wanted, after three fade times
NEAR, STAYING, PATIENCE = 3.0, 5.0, 120.0  # m off the range; s there; s until then
MOTION = ("stamp", "heading", "path_angle", "turn_rate", "path_angle_rate", "airspeed")
NUMBERS = [known for known in specifications(type(FLIGHT)) if isinstance(known.default, float)]
FREE = [known.name for known in NUMBERS if not known.fixed]


def refused(kind, call):
    """Why a call was refused, in words; empty if it was not."""
    try:
        call()
    except kind as error:
        return str(error)
    return ""


class Flight(ClosedLoop):
    """A mission whose controller is held against what it promises, at every command.

    Attributes:
        formulation: Of which solves can be made to fail.
        lost: What does not arrive: "state", "target".
        engaged: Whether the aircraft flies the commands.
        slow: Time that the controller takes for an answer in [s].
        quiet: Time since which nothing but the flight itself changes what is wanted, in [s].
    """

    def __init__(self):
        self.formulation = Faulty(FlightFormulation(CONFIGURATION.controller, small_uav.solver()))
        self.lost, self.engaged, self.slow, self.quiet, self.spent = set(), True, 0.0, 0.0, 0.0
        super().__init__(CONFIGURATION, self.formulation)
        self.stamps, self.commands, self.changes, self.plan = [], 0, None, None

    def _new_controller(self, formulation):
        return Controller(CONFIGURATION.controller, formulation, self.steady)

    def steady(self):
        """Steady clock in [s]; an answer takes what passes from one reading to the next."""
        self.spent += self.slow
        return self.time + self.spent

    def change(self, **values):
        """Change parameters, or hear why not."""
        if values.get("control_rate", self.pace) != self.pace:
            self.stamps = []
        words = refused(ParameterError, lambda: self.controller.change(**values))
        assert not words or any(name in words for name in values)
        self.quiet = self.time

    @property
    def pace(self):
        """Commands a second that are asked for, in [Hz]."""
        return self.controller.parameters.control_rate

    def see_target(self, stamp, position):
        """Hand a target over, or hear that it is ahead of the states."""
        words = refused(MeasurementError, lambda: self.controller.see_target(stamp, position))
        assert not words or "do the clocks agree?" in words

    def answer(self, sightings, measured, now):
        if "target" not in self.lost:
            for stamp, position in sightings:
                self.see_target(stamp, position)
        if "state" in self.lost:
            return None
        command = self.controller.step(measured, now)
        if command is not None:
            self.check(command)
        return command if self.engaged else None

    def check(self, command):
        self.commands += 1
        self.check_rate(command.stamp)
        self.check_mode(command)
        lower, upper = limits(self.controller.parameters, self.plant.state[5])
        assert np.isfinite(command.inputs).all()
        # The bank limits the turn rate at the airspeed when the command takes effect.
        slack = np.array([0.2 * upper[0], 1e-9, 1e-9])
        assert (command.inputs >= lower - slack).all()
        assert (command.inputs <= upper + slack).all()

    def check_rate(self, stamp):
        self.stamps.append(stamp)
        periods = (stamp - self.stamps[0]) * self.pace
        assert len(self.stamps) - 1 <= periods + 1.02, "more commands than the control rate"

    def check_mode(self, command):
        """What is reported is flown: all of it after three fade times without a change."""
        mode, modes = command.mode, self.controller.modes
        assert mode is modes.mode is not FallbackMode.SILENCE
        counted = sum(modes.counts.values()) - modes.counts[FallbackMode.SILENCE]
        assert counted == self.commands
        if mode in (FallbackMode.OPTIMAL, FallbackMode.FEASIBLE):
            wanted, self.plan = command.plan.inputs[0], (command.stamp, command.plan)
        elif mode is FallbackMode.EARLIER_PLAN:
            begin, plan = self.plan
            wanted = plan.inputs[int((command.stamp - begin) / plan.step)]
        else:
            assert len(command.inputs) == 1
            wanted = None
        if modes.changes != self.changes:  # into silence and out of it too
            self.changes, self.quiet = modes.changes, command.stamp
        if wanted is not None and command.stamp - self.quiet > 3.0 * FADE_TIME:
            lower, upper = limits(self.controller.parameters, self.plant.state[5])
            off = np.abs(command.inputs[0] - np.clip(wanted, lower, upper))
            assert (off <= LEFT * (upper - lower) + 1e-9).all(), "not what is reported"

    def fly(self, seconds):
        """Fly on for a time in [s]."""
        for _ in range(round(seconds * self.rate)):
            self.tick()

    @property
    def off(self):
        """From the range that is asked for, in [m]."""
        away = math.dist(self.plant.state[:3], self.target.position(self.time))
        return abs(away - self.controller.parameters.range)

    def arrives(self, disturb=lambda tick: None):
        """Whether the flight comes to its range and stays there, with a change at every state."""
        since, end, tick = None, self.time + PATIENCE, 0
        while self.time < end:
            disturb(tick)
            self.tick()
            tick += 1
            since = None if self.off > NEAR else since or self.time
            if since is not None and self.time - since >= STAYING:
                return True
        return False


class Walk(RuleBasedStateMachine):
    """Changes, failures and losses in any order; in the end the flight goes where it is asked."""

    @initialize(plan_age=st.sampled_from((0.0, 1.0)))
    def take_off(self, plan_age):
        self.flight = Flight()
        self.flight.change(plan_age_max=plan_age)
        self.flight.fly(1.0)

    @rule(
        values=st.fixed_dictionaries(
            {},
            optional={
                "range": st.floats(200.0, 400.0),
                "altitude": st.floats(90.0, 150.0),
                "airspeed": st.floats(18.0, 26.0),
                "bank_max": st.floats(0.5, 0.8),
                "direction": st.sampled_from(("nearest", "clockwise", "counter_clockwise")),
                "control_rate": st.sampled_from((5.0, 8.0, 10.0, 20.0)),
                "response_estimation": st.booleans(),
            },
        ),
        every=st.sampled_from((0, 1, 3)),
    )
    def changes(self, values, every):
        """Once, or with every state, for a second."""
        for tick in range(20):
            if tick == 0 or (every and tick % every == 0):
                self.flight.change(**values)
            self.flight.tick()

    @rule(
        status=st.sampled_from((None, Status.FAILED, Status.TIME_LIMIT)),
        error=st.sampled_from((None, ValueError("no"), ZeroDivisionError("by zero"))),
        alternating=st.booleans(),
        seconds=st.sampled_from((0.2, 1.0, 3.0)),
    )
    def solves_fail(self, status, error, alternating, seconds):
        solver = self.flight.formulation
        for tick in range(round(20 * seconds)):
            fails = not alternating or tick // 2 % 2 == 0
            solver.status, solver.error = (status, error) if fails else (None, None)
            self.flight.tick()
        solver.status = solver.error = None

    @rule(
        what=st.sets(st.sampled_from(("state", "target")), min_size=1),
        seconds=st.sampled_from((0.1, 0.7, 3.0, 8.0)),
        said=st.booleans(),
    )
    def something_is_lost(self, what, seconds, said):
        self.flight.lost = what
        self.flight.fly(seconds)
        if said and "state" in what:
            self.flight.controller.fall_silent("vehicle state is lost")
        self.flight.lost = set()
        self.flight.fly(0.5)

    @rule(engaged=st.booleans(), forgets=st.booleans())
    def engages(self, engaged, forgets):
        self.flight.engaged = engaged
        if forgets:
            self.flight.controller.reset()
        self.flight.controller.engage(engaged)
        self.flight.fly(0.5)

    @rule()
    def an_answer_is_late(self):
        self.flight.slow = 1.0
        self.flight.fly(0.2)
        self.flight.slow = 0.0
        self.flight.fly(0.2)

    @rule()
    def nothing(self):
        self.flight.fly(1.0)

    @precondition(lambda self: self.flight.controller.flying)
    @rule(when=st.sampled_from((-9.0, 0.3, 4.0, 9.0)))
    def a_stamp_is_wrong(self, when):
        """Of a target, that is where it is."""
        self.flight.see_target(self.flight.time + when, [0.0, 0.0, 0.0])

    def teardown(self):
        flight = getattr(self, "flight", None)
        if flight is None:
            return
        flight.engaged = True
        flight.controller.engage(True)
        assert flight.arrives(), f"{flight.off:.0f} m off, {flight.controller.modes.mode}"


TestWalk = Walk.TestCase
TestWalk.settings = settings(
    max_examples=settings.default.max_examples // 5,  # a walk has a dozen steps
    stateful_step_count=12,
    phases=(Phase.generate,),
)


def test_a_flight_arrives_while_a_parameter_changes_with_every_state():
    flight = Flight()
    wanted = [300.0, 300.5]
    assert flight.arrives(lambda tick: flight.change(range=wanted[tick % 2]))


def test_a_flight_arrives_while_every_other_solve_fails():
    flight = Flight()
    flight.change(plan_age_max=0.0)

    def fail(tick):
        flight.formulation.status = (None, Status.FAILED)[tick // 2 % 2]

    assert flight.arrives(fail)
    counts = flight.controller.modes.counts
    assert counts[FallbackMode.OPTIMAL] > 0 < counts[FallbackMode.LOITER]


anything = st.floats() | st.sampled_from([0.0, -1.0, math.nan, math.inf, -math.inf, 1e300, -1e300])
vector = st.lists(anything, min_size=3, max_size=3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(phases=(Phase.generate,))
@given(
    parameter=st.tuples(st.sampled_from(FREE), anything),
    target=st.tuples(anything, vector, st.none() | vector),
    air=st.tuples(anything, anything),
    state=st.dictionaries(st.sampled_from(MOTION), anything, max_size=2),
    place=st.none() | vector,
)
def test_any_number_is_taken_or_refused_in_words(parameter, target, air, state, place):
    flight = Flight()
    flight.fly(0.3)
    controller, good = flight.controller, flight.plant.measured()
    words = [
        refused(ParameterError, lambda: controller.change(**dict([parameter]))),
        refused(MeasurementError, lambda: controller.see_target(*target)),
        refused(MeasurementError, lambda: controller.see_air(*air)),
        refused(MeasurementError, lambda: controller.step(odd(good, state, place), flight.time)),
    ]
    for names, values in (
        (parameter[:1], parameter[1:]),
        (("target",), target[1]),
        (("airspeed",), air[1:]),
        ((*state, "position"), (*state.values(), *(place or ()))),
    ):
        named = any(name in why for name in names for why in words)
        assert named or np.isfinite(values).all()
    for tick in range(4):
        stamp = flight.time + 0.05 * tick
        again = odd(good, {"stamp": stamp}, None)
        command = controller.step(again, stamp)
        if command is not None:
            lower, upper = limits(controller.parameters, 0.1)
            assert np.isfinite(command.inputs).all()
            assert (np.abs(command.inputs) <= np.maximum(np.abs(lower), np.abs(upper))).all()


def odd(good, changed, place):
    """A measurement with a few values that are anything."""
    values = {field.name: getattr(good, field.name) for field in fields(Measurement)} | changed
    return Measurement(**(values if place is None else {**values, "position": np.array(place)}))
