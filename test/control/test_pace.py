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


import numpy as np
import pytest

from uav_tracking_mpc.control.controller import Pace


@pytest.mark.parametrize(
    ("rate", "expected"), [(10.0, 10.0), (15.0, 15.0), (8.0, 8.0), (20.0, 20.0), (50.0, 20.0)]
)
def test_commands_keep_their_rate_on_the_average_up_to_that_of_the_states(rate, expected):
    """States at 20 Hz for 60 s."""
    pace = Pace(rate)
    stamps = (np.arange(1200) * 0.05).tolist()
    assert sum(pace.due(stamp) for stamp in stamps) == pytest.approx(expected * 60, abs=2)


def test_lost_time_is_not_caught_up_with():
    pace = Pace(10.0)
    assert pace.due(0.0)
    assert pace.due(5.0)
    assert not pace.due(5.05)
    assert pace.due(5.1)


def test_where_time_went_back_the_next_state_is_due():
    pace = Pace(1.0)
    pace.due(10.0)
    assert pace.due(0.0)


def test_another_rate_counts_from_the_command_before():
    pace = Pace(1.0)
    assert pace.due(10.0)
    pace.rate = 10.0
    assert not pace.due(10.05)
    assert pace.due(10.1)


def kept(states, commands, seconds=8.0):
    """A keeper of 10 Hz that has seen states and commands at rates in [Hz]."""
    keeper = Pace(10.0)
    for time in np.arange(0.0, seconds, 1.0 / states):
        keeper.state(time)
    for time in np.arange(0.0, seconds, 1.0 / commands):
        keeper.sent(time)
    return keeper


def test_a_rate_that_is_kept_is_no_complaint():
    keeper = kept(20.0, 10.0)
    assert keeper.complaint() == ""
    assert (keeper.missed, keeper.late) == (0, 0)


@pytest.mark.parametrize(
    ("states", "commands", "words"),
    [
        (20.0, 5.0, "keeps 5.0 Hz of the 10 Hz asked for"),
        (4.0, 4.0, "keeps 4.0 Hz of the 10 Hz asked for: states come at 4.0 Hz only"),
    ],
)
def test_a_complaint_names_both_rates(states, commands, words):
    assert kept(states, commands).complaint() == words


def test_periods_without_a_command_are_counted():
    keeper = kept(20.0, 10.0, 1.0)  # the last command at 0.9 s
    keeper.sent(1.3)
    assert (keeper.missed, keeper.late) == (3, 1)


@pytest.mark.parametrize("again", [Pace.reset, lambda keeper: keeper.sent(-50.0)])
def test_when_time_begins_anew_nothing_is_known(again):
    keeper = kept(20.0, 5.0)
    again(keeper)
    assert keeper.complaint() == ""


def opinions(keeper, rates, begin=0.0):
    """Whether there is a complaint after each command, at one rate [Hz] after the other."""
    heard, time = [], begin
    for rate, seconds in rates:
        end = time + seconds
        while time < end:
            keeper.state(time)
            keeper.sent(time)
            heard.append(bool(keeper.complaint()))
            time += 1.0 / rate
    return heard


def changes(heard):
    return int(np.count_nonzero(np.diff(np.array(heard, dtype=int))))


def test_a_rate_that_wavers_about_the_least_one_is_one_complaint():
    """A loaded machine: between 8.6 and 9.6 Hz of 10, each for a second."""
    heard = opinions(Pace(10.0), [(8.6, 1.0), (9.6, 1.0)] * 20)
    assert changes(heard) <= 1


def test_missed_and_kept_again_are_each_said_once_and_late():
    heard = opinions(Pace(10.0), [(10.0, 5.0), (5.0, 8.0), (10.0, 8.0)])
    assert changes(heard) == 2
    assert not heard[-1]
    begin, end = heard.index(True), len(heard) - heard[::-1].index(True)
    assert begin > 50 + 0.9 * 3.0 * 5.0  # 3 s at 5 Hz after the rate had fallen
    assert end > 50 + 40 + 0.9 * 3.0 * 10.0


def test_a_short_lapse_is_no_complaint():
    heard = opinions(Pace(10.0), [(10.0, 5.0), (5.0, 1.0), (10.0, 5.0)])
    assert not any(heard)
