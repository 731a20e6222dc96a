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

"""What the links to both autopilots do alike, flown against the simulated ones."""

import math
import re

import numpy as np
import pytest
from stepped_flight import ORBIT, ByController, Nobody, engaged_flight, flight

OURS = {"ardupilot": "GUIDED", "px4": "OFFBOARD"}
BOTH = pytest.mark.parametrize("dialect", ["ardupilot", "px4"])


@BOTH
def test_nothing_is_sent_unless_somebody_engages(dialect):
    flown = flight(dialect).fly(3.0)
    assert flown.sent == []
    assert flown.autopilot.core.mode == "LOITER"


@BOTH
def test_there_must_be_something_to_fly_first(dialect):
    assert "nothing to fly yet" in flight(dialect).fly(1.0, Nobody()).link.engage()


def circled(flown):
    """RMS of range error [m], altitude error [m], roll rate [deg/s], change of bank [deg]."""
    controller = ByController(flown)
    assert flown.engage(controller) == ""
    settled = flown.time + 25.0
    flown.fly(35.0, controller)
    banks = np.degrees([target.roll for time, target in flown.sent if time > settled])
    return *controller.since(settled), np.sqrt(np.mean(np.diff(banks) ** 2))


@pytest.mark.parametrize(("dialect", "scenario"), [("ardupilot", "wind"), ("px4", "crosswind")])
def test_it_circles_in_wind_and_about_a_moving_target(dialect, scenario):
    flown = flight(dialect, scenario=scenario)
    distance, height, roll_rate, _ = circled(flown)
    assert distance < 0.3
    assert height < 1.0
    assert roll_rate < 5.0
    assert flown.link.values()["commands refused"] == 0


def test_px4s_small_airplane_circles_by_its_own_configuration():
    near = [
        "uav_simulator.initial_position=[170.0, 0.0, 98.0]",
        "uav_simulator.initial_heading=1.6",
    ]
    distance, height, *_ = circled(flight("px4", scenario=None, config="px4_uav", near=near))
    assert distance < 0.3
    assert height < 1.0


@pytest.mark.parametrize(
    ("dialect", "climb", "error", "change"), [("ardupilot", 1.5, 1.0, 1.5), ("px4", 0.0, 0.3, 0.3)]
)
def test_turbulence_does_not_shake_the_bank(dialect, climb, error, change):
    """The bank jumped by 14 deg from one set-point to the next, by 1.2 deg with a shaking nose."""
    flown = flight(dialect)
    flown.shake(0.3, climb)
    distance, _, _, jumps = circled(flown)
    assert distance < error
    assert jumps < change


@pytest.mark.parametrize(
    ("dialect", "mode"),
    [
        *(("ardupilot", mode) for mode in ("FBWA", "MANUAL", "RTL", "LOITER")),
        *(("px4", mode) for mode in ("POSCTL", "MANUAL", "RTL", "LOITER")),
    ],
)
def test_a_pilot_takes_over_within_one_message_and_for_good(dialect, mode):
    flown = engaged_flight(dialect)
    flown.fly(2.0)
    assert flown.autopilot.pilot_mode(mode)
    # What was under way; CURRENT_MODE of PX4 comes ten times a second.
    noticed = flown.time + {"ardupilot": 0.03, "px4": 0.15}[dialect]
    flown.fly(3.0)
    assert not flown.link.engaged
    assert not flown.sent_after(noticed)
    # Back in our mode, which PX4 refuses: there is no stream that it could fly.
    assert flown.autopilot.pilot_mode(OURS[dialect]) == (dialect == "ardupilot")
    flown.fly(3.0)
    assert not flown.sent_after(noticed)
    assert any("took over" in words for words in flown.words)


@BOTH
def test_giving_command_back_sends_nothing_more(dialect):
    flown = engaged_flight(dialect)
    flown.link.disengage()
    at = flown.time
    flown.fly(2.0)
    assert not flown.sent_after(at + 0.02)  # one may be under way


@BOTH
def test_a_dead_link_is_taken_up_again(dialect):
    flown = engaged_flight(dialect)
    fault = flown.autopilot.begin_fault("silence")
    flown.fly(8.0)
    if dialect == "px4":
        assert flown.autopilot.core.mode == "LOITER"
    flown.autopilot.end_fault(fault)
    flown.fly(3.0)
    assert flown.link.engaged
    assert flown.autopilot.core.mode == OURS[dialect]
    assert flown.sent_after(flown.time - 0.5)


@pytest.mark.parametrize(
    ("dialect", "changed", "words"),
    [
        ("ardupilot", {"FENCE_ENABLE": 1, "FENCE_TYPE": 1}, "not inside the autopilot's"),
        (
            "ardupilot",
            {"FENCE_ENABLE": 1, "FENCE_TYPE": 2, "FENCE_RADIUS": 250},
            "leaves the autopilot's fence",
        ),
        ("px4", {"COM_OBL_RC_ACT": 0}, "COM_OBL_RC_ACT is 0 .Position."),
        ("px4", {"COM_OF_LOSS_T": 30.0}, "COM_OF_LOSS_T is 30 s"),
        ("px4", {"MAV_FWDEXTSP": 0}, "MAV_FWDEXTSP is 0"),
        ("px4", {"GF_MAX_HOR_DIST": 250.0}, "leaves the autopilot's fence"),
        ("px4", {"GF_MAX_VER_DIST": 100.0}, "not inside the autopilot's fence"),
    ],
)
def test_what_does_not_fit_is_refused(dialect, changed, words):
    flown = flight(dialect, **changed)
    assert re.search(words, flown.engage())
    assert flown.sent == []


@BOTH
def test_a_plan_that_cannot_be_flown_is_refused_in_words(dialect):
    link = flight(dialect).link
    level, now = np.zeros((2, 3)), link.now()
    assert "not finite" in link.command(now, level * math.nan, 0.5)
    assert "must be finite" in link.command(now, level, 0.5, ORBIT._replace(radius=math.nan))
