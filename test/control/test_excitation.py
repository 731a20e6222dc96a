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

"""The test signal: what it is, and when it is flown."""

from dataclasses import replace

import numpy as np
import pytest
from controller_cases import FLIGHT

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.excitation import (
    CALM_TIME,
    FADE_TIME,
    HALVES,
    RESUME_TIME,
    Doublets,
    Excitation,
)
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.parameters.specification import changed

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
    flown.added(CALM_TIME + 2.0 * FADE_TIME)
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
    begun = np.abs(flown.added(2.0 * FADE_TIME + 2.0 * STEP))
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
    gone = flown.added(FADE_TIME + STEP, present, mode)
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
    fading = np.abs(flown.added(FADE_TIME + STEP))
    assert np.all(fading[0] > 0.8 * AMPLITUDES) and np.all(fading[-1] < 1e-12)


def test_a_target_elsewhere_makes_no_difference():
    flown = Flown()
    flown.added(CALM_TIME + 2.0 * FADE_TIME, situation(target=(500.0, -300.0, 10.0)))
    assert flown.words() == ["the excitation begins"]


def test_what_the_autopilot_holds_is_not_excited():
    added = going(autopilot_holds=True).added(20.0)
    assert np.abs(added[:, 0]).max() == pytest.approx(AMPLITUDES[0])
    assert not added[:, 1:].any()


def test_a_signal_on_nothing_that_is_commanded_is_none():
    flown = Flown(autopilot_holds=True, excitation=(0.0, 0.1, 1.0))
    assert not flown.added(20.0).any()
    assert flown.words() == []
