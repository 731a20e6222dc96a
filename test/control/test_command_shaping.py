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


import math
from dataclasses import replace

import numpy as np
import pytest
from controller_cases import FLIGHT

from uav_tracking_mpc.control.command_shaping import (
    CALM_TIME,
    EXCITATION_FADE_TIME,
    FADE_TIME,
    HALVES,
    RESUME_TIME,
    WAIT_TIME,
    CommandShaper,
    Doublets,
    Excitation,
)
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.tracking import usual_excitation

PLAN = np.tile([0.1, 0.05, 0.3], (5, 1))
LAW = np.array([[-0.1, 0.0, -0.2]])


@pytest.fixture
def shaper():
    return CommandShaper(FLIGHT, EventLog())


def test_inputs_are_kept_inside_limits_that_the_airspeed_decides(shaper):
    wild = np.array([[9.0, -9.0, 99.0], [np.nan, np.inf, -np.inf]])
    shaped = shaper.shape(0.0, wild, 1.0, 25.0, FallbackMode.OPTIMAL)
    turn = FLIGHT.envelope.turn_rate_max(25.0)
    np.testing.assert_array_equal(
        shaped[0], [turn, -FLIGHT.pitch_rate_max, FLIGHT.acceleration_max]
    )
    np.testing.assert_array_equal(shaped[1], 0.0)


def test_an_aircraft_that_slips_is_not_banked_beyond_its_limit(shaper):
    wild = np.array([[9.0, 0.0, 0.0], [-9.0, 0.0, 0.0]])
    turn = FLIGHT.envelope.turn_rate_max(25.0)
    shaped = shaper.shape(0.0, wild, 1.0, 25.0, FallbackMode.OPTIMAL, -0.1)
    np.testing.assert_allclose(shaped[:, 0], [turn - 0.1, -turn])
    shaped = shaper.shape(0.0, wild, 1.0, 25.0, FallbackMode.OPTIMAL, 0.1)
    np.testing.assert_allclose(shaped[:, 0], [turn, 0.1 - turn])


def test_plans_follow_each_other_as_they_are(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    for mode in (FallbackMode.EARLIER_PLAN, FallbackMode.FEASIBLE, FallbackMode.OPTIMAL):
        np.testing.assert_array_equal(shaper.shape(0.1, -PLAN, 0.5, 22.0, mode), -PLAN)


def test_a_law_takes_over_from_a_plan_little_by_little(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    for time in (0.0, 0.1, 0.5, 9.0):
        (shaped,) = shaper.shape(time, LAW, 1.0, 22.0, FallbackMode.LOITER)
        share = np.exp(-time / FADE_TIME)
        np.testing.assert_allclose(shaped, share * PLAN[0] + (1.0 - share) * LAW[0], atol=1e-12)


def test_within_a_plan_the_fading_goes_on(shaper):
    shaper.shape(0.0, LAW, 1.0, 22.0, FallbackMode.LOITER)
    shaped = shaper.shape(0.1, PLAN, 0.25, 22.0, FallbackMode.OPTIMAL)
    share = np.exp(-0.25 * np.arange(5) / FADE_TIME)[:, np.newaxis]
    np.testing.assert_allclose(shaped, PLAN + share * (LAW - PLAN), atol=1e-12)


def test_other_parameters_take_over_without_a_jump(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    shaper.change(replace(FLIGHT, acceleration_max=1.0))
    shaped = shaper.shape(0.1, -PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    np.testing.assert_allclose(shaped[0], PLAN[0], atol=1e-12)


def test_a_change_with_every_command_makes_it_lag_and_never_stops_it(shaper):
    """The turn rate that is wanted rises by 0.1 rad/s in a second, at 20 Hz."""
    for count in range(61):
        wanted = np.array([[0.005 * count - 0.1, 0.0, 0.0]])
        shaper.change(FLIGHT)
        (shaped,) = shaper.shape(0.05 * count, wanted, 1.0, 22.0, FallbackMode.OPTIMAL)
    lag = wanted[0] - shaped
    np.testing.assert_allclose(lag, [0.1 * FADE_TIME, 0.0, 0.0], rtol=0.15)


def test_two_guidances_that_alternate_are_blended(shaper):
    sent = []
    for count in range(100):
        inputs, mode = [(PLAN, FallbackMode.OPTIMAL), (LAW, FallbackMode.LOITER)][count % 2]
        sent.append(shaper.shape(0.05 * count, inputs, 1.0, 22.0, mode)[0])
    middle = 0.5 * (PLAN[0] + LAW[0])
    np.testing.assert_allclose(sent[-2:], [middle, middle], atol=0.1 * np.max(PLAN[0] - LAW[0]))


def test_once_all_is_forgotten_the_command_comes_as_it_is(shaper):
    shaper.shape(0.0, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL)
    shaper.reset()
    np.testing.assert_array_equal(shaper.shape(0.1, LAW, 1.0, 22.0, FallbackMode.LOITER), LAW)


@pytest.mark.parametrize("known", [True, False])
def test_after_a_break_the_turn_goes_on_from_the_one_that_is_flown(shaper, known):
    shaper.shape(0.0, LAW, 1.0, 22.0, FallbackMode.LOITER)
    shaper.pause()
    flown = replace(situation(), rates=np.array([0.04, 0.2, 0.1])) if known else None
    begin = 0.04 if known else PLAN[0, 0]
    for time in (9.0, 9.1, 9.5):
        shaped = shaper.shape(time, PLAN, 0.5, 22.0, FallbackMode.OPTIMAL, present=flown)
        share = math.exp(-(time - 9.0) / FADE_TIME)
        assert shaped[0, 0] == pytest.approx(PLAN[0, 0] + share * (begin - PLAN[0, 0]))
        np.testing.assert_array_equal(shaped[:, 1:], PLAN[:, 1:])


AMPLITUDES = np.array([0.06, 0.05, 1.0])
STEP = 0.05  # s
BASE = np.array([[0.08, 0.0, 0.0], [0.07, 0.0, 0.0]])
ORBIT = FLIGHT.orbit


def situation(height=0.0, airspeed=ORBIT.speed, path_angle=0.0, target=(0.0, 0.0, 0.0)):
    position = np.array([ORBIT.radius, 0.0, ORBIT.altitude + height]) + target
    vehicle = np.array([*position, 0.5 * np.pi, path_angle, airspeed])
    return Situation(vehicle, np.array(target), np.zeros(3), np.zeros(3), np.zeros(3))


class Flown:
    """An excitation, asked every 50 ms."""

    def __init__(self, **parameters):
        self.events = EventLog()
        self.parameters = changed(FLIGHT, {"excitation": tuple(AMPLITUDES), **parameters})
        self.excitation = Excitation(self.parameters, self.events)
        self.time = 100.0

    def added(self, duration, present=None, mode=FallbackMode.OPTIMAL, base=BASE):
        """What is added to the first segment over a time, shape (n, 3)."""
        present, found = present or situation(), []
        for _ in range(round(duration / STEP)):
            inputs = self.excitation.added(self.time, base, mode, ORBIT, present)
            assert np.array_equal(inputs[1:], base[1:])
            found.append(inputs[0] - base[0])
            self.time += STEP
        return np.array(found)

    def words(self):
        return [event.words for event in self.events.take()]


def going(**parameters):
    """One that has been flown for a while."""
    flown = Flown(**parameters)
    flown.added(CALM_TIME + 2.0 * EXCITATION_FADE_TIME)
    assert flown.words() == ["the excitation begins"]
    return flown


def test_a_doublet_comes_back_to_where_it_began():
    period, step = 2.0 * sum(HALVES), 0.001
    signal = Doublets(1)
    values = np.array([signal.value((k + 0.5) * step) for k in range(round(3.0 * period / step))])
    assert set(values) == {-1.0, 1.0}
    integral = np.cumsum(values) * step
    cycles = np.round(period / step * np.arange(1, 4)).astype(int) - 1
    np.testing.assert_allclose(integral[cycles], 0.0, atol=1e-2)
    assert np.max(np.abs(integral)) <= max(HALVES) + 1e-2


def test_channels_can_be_told_apart():
    time = np.arange(0.0, 60.0, STEP)
    signals = np.array([[signal.value(t) for t in time] for signal in map(Doublets, range(3))])
    correlation = np.corrcoef(signals)
    assert np.max(np.abs(correlation[np.triu_indices(3, 1)])) < 0.3


def test_without_an_amplitude_commands_are_passed_on_as_they_are():
    excitation = Excitation(FLIGHT, EventLog())
    assert excitation.added(0.0, BASE, FallbackMode.OPTIMAL, ORBIT, situation()) is BASE


def test_it_begins_on_the_orbit_and_fades_in():
    flown = Flown()
    np.testing.assert_array_equal(flown.added(CALM_TIME - STEP), 0.0)
    begun = np.abs(flown.added(2.0 * EXCITATION_FADE_TIME + 2.0 * STEP))
    assert np.all(np.max(np.abs(np.diff(begun, axis=0)), axis=0) <= AMPLITUDES * 2.0 * STEP)
    np.testing.assert_allclose(begun[-1], AMPLITUDES)


@pytest.mark.parametrize(
    ("present", "mode", "reason"),
    [
        (situation(), FallbackMode.FEASIBLE, "feasible plan"),
        (situation(height=25.0), FallbackMode.OPTIMAL, "off the orbit"),
        (situation(airspeed=28.5), FallbackMode.OPTIMAL, "airspeed"),
        (situation(path_angle=-0.14), FallbackMode.OPTIMAL, "path angle"),
    ],
    ids=["fallback", "off", "fast", "steep"],
)
def test_it_is_suspended_and_fades_out(present, mode, reason):
    flown = going()
    gone = flown.added(EXCITATION_FADE_TIME + STEP, present, mode)
    assert np.all(np.abs(gone[-1]) < 1e-12)
    (words,) = flown.words()
    assert "suspended" in words and reason in words
    np.testing.assert_array_equal(flown.added(RESUME_TIME - STEP), 0.0)
    assert np.any(flown.added(3.0 * STEP))
    assert flown.words() == ["the excitation goes on"]


@pytest.mark.parametrize(
    ("limit", "near", "far"),
    [("height_min", 115.0, 100.0), ("distance_min", 292.0, 250.0), ("fence_radius", 290.0, 400.0)],
)
def test_near_a_limit_of_place_it_is_not_flown(limit, near, far):
    np.testing.assert_array_equal(Flown(**{limit: near}).added(CALM_TIME + 1.0), 0.0)
    assert np.any(Flown(**{limit: far}).added(CALM_TIME + 1.0))


SIDEWAYS = """
from dataclasses import dataclass
from uav_tracking_mpc.limits import Bound, Limit

@dataclass(frozen=True)
class Sideways(Limit):
    name = "sideways"

    def stage(self, motion, numbers, xp):
        return Bound(motion.airspeed * motion.turn_rate, -6.0, 6.0)
"""


@pytest.mark.parametrize(("turn_rate", "flown"), [(0.08, True), (0.25, False)])
def test_a_limit_that_somebody_adds_is_told_the_turn(tmp_path, turn_rate, flown):
    (tmp_path / "limit.py").write_text(SIDEWAYS)
    excited = Flown(limits=f"{tmp_path / 'limit.py'}:Sideways")
    present = replace(situation(), rates=np.array([turn_rate, 0.0, 0.0]))
    assert np.any(excited.added(CALM_TIME + 1.0, present)) == flown


def test_a_slow_aircraft_has_room_beside_its_least_airspeed():
    slow, present = replace(ORBIT, speed=9.5), situation(airspeed=9.5)
    excitation = Excitation(
        changed(FLIGHT, {"airspeed_min": 7.8, "excitation": tuple(AMPLITUDES)}), EventLog()
    )
    flown = [
        excitation.added(time, BASE, FallbackMode.OPTIMAL, slow, present)
        for time in (0.0, CALM_TIME, CALM_TIME + 1.0)
    ]
    assert np.any(flown[-1] != BASE)


def test_it_says_what_it_waits_for():
    flown = Flown(height_min=115.0)
    flown.added(WAIT_TIME + 2.0 * STEP)
    assert flown.words() == ["the excitation has not begun yet: near the limit of height"]


@pytest.mark.parametrize("airspeed", [9.5, 22.0, 60.0])
def test_the_usual_signal_takes_no_more_bank_load_and_airspeed_than_usual(airspeed):
    turn, path, acceleration = usual_excitation(airspeed)
    assert turn * airspeed <= 0.06 * 22.0 + 1e-12 and turn <= 0.06
    assert path * airspeed <= 0.11 * 22.0 + 1e-12 and path <= 0.11
    assert acceleration / airspeed <= 1.5 / 22.0 + 1e-12 and acceleration <= 1.5


def test_a_sharp_turn_leaves_no_room_for_it():
    flown = Flown()
    sharp = np.array([[0.95 * FLIGHT.envelope.turn_rate_max(ORBIT.speed), 0.0, 0.0]])
    np.testing.assert_array_equal(flown.added(CALM_TIME + 1.0, base=sharp), 0.0)


def test_commands_stay_inside_the_envelope():
    flown = going(excitation=(0.5, 0.5, 5.0))
    envelope = FLIGHT.envelope
    commanded = BASE[0] + flown.added(2.0 * sum(HALVES))
    least, most = envelope.force_limits(ORBIT.speed)
    assert np.max(np.abs(commanded[:, 0])) <= envelope.turn_rate_max(ORBIT.speed) + 1e-12
    assert np.max(np.abs(commanded[:, 1])) <= FLIGHT.pitch_rate_max
    assert least - 1e-12 <= commanded[:, 2].min() and commanded[:, 2].max() <= most + 1e-12


def test_switched_off_in_flight_it_fades():
    flown = going()
    flown.excitation.change(replace(flown.parameters, excitation=(0.0, 0.0, 0.0)))
    fading = np.abs(flown.added(EXCITATION_FADE_TIME + STEP))
    assert np.all(fading[0] > 0.8 * AMPLITUDES) and np.all(fading[-1] < 1e-12)


def test_a_target_elsewhere_makes_no_difference():
    flown = Flown()
    flown.added(CALM_TIME + 2.0 * EXCITATION_FADE_TIME, situation(target=(500.0, -300.0, 10.0)))
    assert flown.words() == ["the excitation begins"]


def test_what_the_autopilot_holds_is_not_excited():
    added = going(autopilot_holds=True).added(20.0)
    assert np.abs(added[:, 0]).max() == pytest.approx(AMPLITUDES[0])
    assert not added[:, 1:].any()


def test_a_signal_on_nothing_that_is_commanded_is_none():
    flown = Flown(autopilot_holds=True, excitation=(0.0, 0.1, 1.0))
    assert not flown.added(20.0).any()
    assert flown.words() == []
