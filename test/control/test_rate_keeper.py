import numpy as np
import pytest

from uav_tracking_mpc.control.rate_keeper import RateKeeper


def kept(states, commands, seconds=5.0):
    """A keeper of 10 Hz that has seen states and commands at rates in [Hz]."""
    keeper = RateKeeper(10.0)
    for time in np.arange(0.0, seconds, 1.0 / states):
        keeper.state(time)
    for time in np.arange(0.0, seconds, 1.0 / commands):
        keeper.command(time)
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
    keeper.command(1.3)
    assert (keeper.missed, keeper.late) == (3, 1)


@pytest.mark.parametrize("again", [RateKeeper.reset, lambda keeper: keeper.command(-50.0)])
def test_when_time_begins_anew_nothing_is_known(again):
    keeper = kept(20.0, 5.0)
    again(keeper)
    assert keeper.complaint() == ""
