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

"""The slider follows the clock of a record, and leaves the hand that moves it alone."""

import threading
from types import SimpleNamespace

import pytest
from watched_flight_stand_in import StandInFlight, StandInSource

from uav_tracking_mpc.view.panel import replay
from uav_tracking_mpc.view.panel._html import clock as clock_words
from uav_tracking_mpc.view.panel.replay import Replay
from uav_tracking_mpc.view.watched_flight import PlayClock

SLIDER = "time [s]"


@pytest.fixture
def wall():
    """Its ``time`` is that on the wall."""
    return SimpleNamespace(time=0.0)


@pytest.fixture
def clock(wall):
    return PlayClock(-2.0, 600.0, lambda: wall.time)


@pytest.fixture
def shown(panel, clock):
    return panel(Replay, clock)


def test_it_is_there_once_for_all_aircraft_of_a_record(clock):
    source = StandInSource(first := StandInFlight(), second := StandInFlight())
    source.clock = clock
    assert Replay.fits(first, source)
    assert not Replay.fits(second, source)
    source.clock = None
    assert not Replay.fits(first, source)


def test_the_slider_follows_the_clock(shown, clock, wall):
    wall.time = 12.5
    shown.show()
    assert shown.widget(SLIDER).value == 10.5
    assert shown.part._words.content == "**0:10.5** of 10:00.0"
    assert clock.playing


def test_the_slider_shows_whole_steps(shown, wall):
    """The field beside it has no room for more."""
    wall.time = 45.0996
    shown.show()
    slider = shown.widget(SLIDER)
    assert (slider.min, slider.value, slider.max) == (-2.0, 43.1, 600.0)


def test_who_moves_the_slider_moves_the_clock(shown, clock, wall):
    shown.by_hand(SLIDER, 300.0)
    shown.until(lambda: clock.time == 300.0)
    wall.time = 5.0
    assert clock.time == 305.0


def test_a_hand_is_heard_though_the_panel_is_drawn_before_its_callback(shown, clock):
    clock.pause()
    go_on = threading.Event()
    shown.gui._thread_executor.submit(go_on.wait)
    shown.send(SLIDER, 300.0)
    shown.send("speed", "5x")
    shown.show()
    go_on.set()
    shown.by_hand("jump", "of nobody")
    assert (clock.time, clock.rate) == (300.0, 5.0)


def test_what_no_page_sends_moves_nothing(shown, clock, wall, capfd):
    wall.time = 12.5
    shown.by_hand(SLIDER, float("nan"))
    shown.by_hand("speed", "of nobody")
    shown.by_hand("jump", "of nobody")
    shown.by_hand(SLIDER, 100.0)
    shown.until(lambda: clock.time == 100.0)
    assert shown.widget("speed").value == "1x"
    assert capfd.readouterr().err == ""


def test_the_slider_is_left_to_the_hand_that_moves_it(shown, clock, wall, monkeypatch):
    shown.by_hand(SLIDER, 300.0)
    shown.until(lambda: clock.time == 300.0)
    wall.time = 5.0
    monkeypatch.setattr(replay, "HAND", float("inf"))
    shown.show()
    assert shown.widget(SLIDER).value == 300.0
    monkeypatch.setattr(replay, "HAND", 0.0)
    shown.show()
    assert shown.widget(SLIDER).value == 305.0


def test_play_and_pause(shown, clock, wall):
    shown.by_hand("pause", True)
    shown.until(lambda: not clock.playing and "play" in shown.labels())
    wall.time = 50.0
    shown.show()
    assert shown.widget(SLIDER).value == -2.0
    shown.by_hand("play", True)
    shown.until(lambda: clock.playing and "pause" in shown.labels())


def test_speed_changes_where_the_record_stands(shown, clock, wall):
    wall.time = 10.0
    shown.by_hand("speed", "5x")
    shown.until(lambda: clock.rate == 5.0)
    assert clock.time == 8.0
    wall.time = 11.0
    assert clock.time == 13.0
    clock.pause()
    shown.by_hand("speed", "2x")
    shown.until(lambda: clock.rate == 2.0)
    assert not clock.playing
    assert clock.time == 13.0


def test_jumps_stay_within_the_record(shown, clock):
    clock.pause()
    shown.by_hand("jump", "+1 min")
    shown.until(lambda: clock.time == 58.0)
    for _ in range(2):
        shown.by_hand("jump", "-1 min")
    shown.until(lambda: clock.time == -2.0)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0, "0:00.0"),
        (-3.25, "-0:03.2"),
        (59.96, "1:00.0"),
        (7384.5, "2:03:04.5"),
        (86400e4 + 60.0, "00:01:00 UTC"),
    ],
)
def test_time_in_words(seconds, words):
    assert clock_words(seconds) == words
