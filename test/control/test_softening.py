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

"""A loop that swings is made slower until it stops, and comes back as far as it stays quiet."""

from dataclasses import replace

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.control.softening import MOST, QUIET, STEP, Softening
from uav_tracking_mpc.control.watches import Swing
from uav_tracking_mpc.estimation.situation import steady_forecast
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.comparison.measures import measures
from uav_tracking_mpc.studies.comparison.scenarios import mismatched

SWING, STILL = (Swing(2.0, 0.2), None), (None, None)
DELAYS, GAINS = np.full(3, 0.5), np.ones(3)


class Flight:
    """Time goes on in steps of 0.1 s."""

    def __init__(self):
        self.events, self.time = EventLog(), 0.0
        self.softening = Softening(self.events)

    def fly(self, seconds, swings, delays=DELAYS, going_on=None):
        going_on = going_on or tuple(swing is not None for swing in swings)
        for _ in range(round(seconds / 0.1)):
            self.time += 0.1
            self.softening.follow(self.time, swings, going_on, delays, GAINS)
        return self.softening.factors.tolist()


def test_a_swing_is_answered_at_once_and_as_long_as_it_goes_on():
    flight = Flight()
    assert flight.fly(0.1, SWING) == [STEP, 1.0, 1.0]
    assert flight.fly(2.5, SWING) == [STEP, 1.0, 1.0]
    assert flight.fly(1.0, SWING) == [STEP**2, 1.0, 1.0]
    assert flight.fly(60.0, SWING) == [MOST, 1.0, 1.0]
    words = [event.words for event in flight.events.take()]
    assert words[0] == "the loop is softened: changes of the turn rate weigh 8 times as much"


def test_a_swing_that_dies_away_is_left_to_it():
    assert Flight().fly(30.0, SWING, going_on=(False, True)) == [1.0, 1.0, 1.0]


def test_the_gain_comes_back_only_so_far_that_it_stays_quiet():
    flight = Flight()
    flight.fly(0.1, SWING)
    assert flight.fly(QUIET - 1.0, STILL)[0] == STEP
    back = flight.fly(100.0, STILL)[0]
    assert 1.0 < back < STEP
    assert flight.fly(600.0, STILL)[0] == back


def test_where_time_goes_back_swings_are_answered_and_the_gain_comes_back_as_before():
    flight = Flight()
    flight.time = 1000.0
    flight.fly(0.1, SWING)
    flight.time = 0.0
    assert flight.fly(QUIET + 5.0, STILL)[0] < STEP
    assert flight.fly(0.1, SWING)[0] > STEP


def test_the_gain_stays_as_it_is_while_the_target_swings_as_well():
    """Whether the loop is quiet cannot be told then."""
    flight = Flight()
    flight.fly(0.1, SWING)
    assert flight.fly(100.0, STILL, going_on=(True, False))[0] == STEP
    assert flight.fly(100.0, STILL)[0] < STEP


def test_however_often_commands_come_the_problem_is_told_every_change():
    """At 200 Hz one change is smaller than that of a digit that anybody would look at."""
    softening, told = Softening(EventLog()), 1.0
    for tick in range(200 * 120):
        swings = SWING if tick == 0 else STILL
        if softening.follow(tick / 200.0, swings, (tick == 0, False), DELAYS, GAINS):
            told = float(softening.factors[0])
        assert told == softening.factors[0]
    assert 1.0 < told < STEP


def test_another_response_is_another_loop():
    flight = Flight()
    flight.fly(0.1, SWING)
    assert flight.fly(200.0, STILL, delays=DELAYS + 0.2)[0] == 1.0
    assert flight.events.take()[-1].words.endswith("weigh as they are told again")


def test_a_new_flight_begins_with_what_is_told():
    flight = Flight()
    flight.fly(0.1, SWING)
    flight.softening.reset()
    assert flight.softening.factors.tolist() == [1.0, 1.0, 1.0]


def test_a_loop_that_cannot_learn_ends_its_cycle_all_the_same():
    """Commands are 0.4 s late from 5 s on, which is beyond the delay margin."""
    told = ["nmpc_controller.response_estimation=false", "mission.duration=100"]
    told += ["uav_simulator.initial_position=[300.0, 0.0, 120.0]"]
    told += ["uav_simulator.initial_heading=1.5707963267948966"]
    configuration = load_configuration("small_uav", told, "crosswind")
    late = ((5.0, "uav_simulator.command_delay=0.4"),)
    log = simulate(replace(configuration, changes=late))
    flown = measures(log, configuration.controller, settled_after=85.0)
    assert log.softened > 1.0
    assert flown.swing_deg < 3.0
    assert flown.range_rms_m < 0.5


@pytest.mark.parametrize("period", [pytest.param(4.0, marks=pytest.mark.long), 12.0])
def test_a_target_that_weaves_is_followed_with_the_whole_gain(period):
    told = ("mission.duration=60", f"target_publisher.weave_period={period}")
    assert simulate(mismatched("small_uav", "weaving_target", told)).softened == 1.0


def test_weights_of_rates_are_multiplied_in_the_problem():
    parameters = load_configuration("small_uav").controller
    formulation = formulation_of(parameters)
    where = formulation.flight.where["rate_weights"]
    formulation.soften(np.array([8.0, 1.0, 1.0]))
    told = parameters.rate_weights
    expected = [8.0 * told[0], *told[1:]]
    ahead = steady_forecast(small_uav.situation(300.0, 0.0, 120.0, 1.6), parameters.horizon)
    assert formulation.data(ahead, parameters.orbit)[0, where] == pytest.approx(expected)
