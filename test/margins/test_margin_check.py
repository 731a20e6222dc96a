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

import re
import threading
from unittest.mock import Mock

import pytest
import small_uav

from uav_tracking_mpc.margins import margin_check
from uav_tracking_mpc.margins.loop_margins import UNSTABLE
from uav_tracking_mpc.margins.margin_check import MarginWatch, margin_warning, shortfalls
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop

HASTY = ("input_weights=[0.04, 0.04, 0.2]", "rate_weights=[0.0, 0.0, 0.0]")


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ((), ""),
        (HASTY, r"turn bears 0\..*delay_margin_min is 0.3 s"),
        (("gain_margin_min=60.0",), "gain_margin_min is 60 dB(?!.*delay)"),
        ((*HASTY, "delay_margin_min=0.1", "gain_margin_min=3.0"), ""),
        (("fence_radius=250.0",), "are not known: the orbit that is asked for is left: limits"),
        (("autopilot_holds=true",), ""),
        (("autopilot_holds=true", *HASTY), "turn bears"),
    ],
)
def test_margins_that_are_smaller_than_asked_are_told(overrides, told):
    words = margin_warning(small_uav.parameters(*overrides))
    assert re.search(told, words) if told else words == ""


def test_nothing_asked_nothing_computed(monkeypatch):
    monkeypatch.setattr(margin_check, "OrbitLoop", None)
    assert margin_warning(small_uav.parameters("delay_margin_min=0.0", "gain_margin_min=0.0")) == ""


def test_an_unstable_loop_lacks_everything_that_is_judged():
    assert len(shortfalls(UNSTABLE, small_uav.parameters())) == 6
    assert len(shortfalls(UNSTABLE, small_uav.parameters("autopilot_holds=true"))) == 2


@pytest.mark.parametrize(
    ("outcome", "words"),
    [
        ({"return_value": UNSTABLE}, "the closed loop is not stable on its orbit"),
        (
            {"side_effect": ArithmeticError("the plan on the orbit: infeasible")},
            "the margins of the closed loop are not known: the plan on the orbit: infeasible",
        ),
    ],
)
def test_a_loop_without_margins_is_told_in_one_sentence(monkeypatch, outcome, words):
    monkeypatch.setattr(OrbitLoop, "margins", Mock(**outcome))
    assert margin_warning(small_uav.parameters()) == words


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


def test_a_series_of_changes_is_judged_once(monkeypatch):
    judge = Mock(return_value=(None, ""))
    monkeypatch.setattr(margin_check, "_warning", judge)
    watch = MarginWatch(lambda words: None, rest=0.3)
    series = [small_uav.parameters(f"range={300.0 + k}") for k in range(5)]
    for each in series:
        watch.ask(each)
    watch.wait()
    # A node of another test that has just ended may still judge its own.
    judged = [call.args for call in judge.call_args_list if call.args[0] in series]
    assert judged == [(series[-1], None)]
