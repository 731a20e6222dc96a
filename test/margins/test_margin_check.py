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

"""Small margins are told in words, in a thread that does not hold up anything."""

import threading

import small_uav

from uav_tracking_mpc.margins.loop_margins import UNSTABLE
from uav_tracking_mpc.margins.margin_check import MarginWatch, margin_warning, shortfalls
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop

HASTY = ("input_weights=[0.04, 0.04, 0.2]", "rate_weights=[0.0, 0.0, 0.0]")


def test_small_uav_is_not_warned_of():
    assert margin_warning(small_uav.parameters()) == ""


def test_a_small_margin_is_named_with_what_is_asked():
    words = margin_warning(small_uav.parameters(*HASTY))
    assert "turn bears 0." in words
    assert "delay_margin_min is 0.3 s" in words


def test_what_is_asked_is_a_parameter():
    words = margin_warning(small_uav.parameters("gain_margin_min=60.0"))
    assert "gain_margin_min is 60 dB" in words
    assert "delay" not in words
    lax = small_uav.parameters(*HASTY, "delay_margin_min=0.1", "gain_margin_min=3.0")
    assert margin_warning(lax) == ""


def test_nothing_asked_nothing_computed(monkeypatch):
    monkeypatch.setattr("uav_tracking_mpc.margins.margin_check.OrbitLoop", None)
    assert margin_warning(small_uav.parameters("delay_margin_min=0.0", "gain_margin_min=0.0")) == ""


def test_an_unstable_loop_lacks_everything():
    assert len(shortfalls(UNSTABLE, small_uav.parameters())) == 6


def test_an_orbit_that_limits_forbid_is_no_alarm_about_margins():
    words = margin_warning(small_uav.parameters("fence_radius=250.0"))
    assert "are not known: the orbit that is asked for is left: limits" in words


def test_a_loop_that_is_not_stable_is_told_in_one_sentence(monkeypatch):
    monkeypatch.setattr(OrbitLoop, "margins", lambda *_: UNSTABLE)
    words = margin_warning(small_uav.parameters())
    assert words == "the closed loop is not stable on its orbit"


def test_an_orbit_without_an_answer_is_told(monkeypatch):
    def fails(self, frozen, plant=None):
        raise ArithmeticError("the plan on the orbit: infeasible")

    monkeypatch.setattr("uav_tracking_mpc.margins.orbit_loop.OrbitLoop.margins", fails)
    assert "not known: the plan on the orbit" in margin_warning(small_uav.parameters())


def test_changes_are_judged_in_a_thread_and_the_latest_wins():
    told, begun = [], threading.Event()

    def report(words):
        told.append((threading.current_thread(), words))
        begun.wait(30.0)  # as long as the first is not taken note of

    watch = MarginWatch(report)
    watch.ask(small_uav.parameters(*HASTY))
    for gain in (20.0, 40.0, 60.0):
        watch.ask(small_uav.parameters(*HASTY, f"gain_margin_min={gain}"))
    begun.set()
    watch.wait()
    assert threading.main_thread() not in [thread for thread, _ in told]
    assert 1 <= len(told) <= 3
    assert "gain_margin_min is 60 dB" in told[-1][1]
    watch.ask(small_uav.parameters())
    watch.wait()
    assert "gain_margin_min is 60 dB" in told[-1][1]  # nothing new


def test_what_the_autopilot_holds_is_not_judged():
    held = small_uav.parameters("autopilot_holds=true")
    assert len(shortfalls(UNSTABLE, held)) == 2
    assert margin_warning(held) == ""
    assert "turn bears" in margin_warning(small_uav.parameters("autopilot_holds=true", *HASTY))


def test_a_series_of_changes_is_judged_once(monkeypatch):
    judged = []

    def judge(parameters, loop):
        judged.append(parameters)
        return None, ""

    monkeypatch.setattr("uav_tracking_mpc.margins.margin_check._warning", judge)
    watch = MarginWatch(lambda words: None, rest=0.3)
    series = [small_uav.parameters(f"range={300.0 + k}") for k in range(5)]
    for each in series:
        watch.ask(each)
    watch.wait()
    assert judged == [series[-1]]
