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

"""Who flies: engaged by somebody, ended by any other mode, resumed only after a dead link."""

import pytest

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.links.mavlink.engagement import PATIENCE, Engagement, State


class Vehicle:
    """Tells its mode once a second."""

    def __init__(self, by_mode=None):
        self.events = EventLog()
        self.engagement = Engagement(self.events, by_mode)
        self.time = 0.0

    def tells(self, mode, armed=True, failsafe=False, after=1.0, silent=False):
        steps = 1 if silent else 10
        for step in range(steps):
            self.engagement.heard(self.time + after * (step + 1) / steps)
        self.time += after
        self.engagement.see_mode(self.time, mode == "OURS", mode, armed, failsafe)
        return self.engagement.state

    def engaged(self):
        self.engagement.ask(self.time, "LOITER")
        assert self.tells("OURS") is State.ENGAGED
        return self


def test_nothing_flies_unless_somebody_engages_and_the_mode_is_there():
    vehicle = Vehicle()
    assert {vehicle.tells(mode) for mode in ("OURS", "LOITER", "OURS", "LOITER")} == {State.IDLE}
    vehicle.engagement.ask(vehicle.time, "LOITER")
    assert [vehicle.tells(mode) for mode in ("LOITER", "OURS")] == [State.ASKING, State.ENGAGED]


def test_asking_ends_though_nothing_is_heard():
    vehicle = Vehicle()
    vehicle.engagement.ask(vehicle.time, "LOITER")
    assert not vehicle.engagement.asked_long_enough(vehicle.time + PATIENCE)
    assert vehicle.engagement.asked_long_enough(vehicle.time + PATIENCE + 0.1)
    assert vehicle.engagement.state is State.IDLE
    assert "stays in mode LOITER" in vehicle.events.take()[-1].words


@pytest.mark.parametrize("before", ["LOITER", "OURS"])
def test_a_pilot_who_changes_the_mode_meanwhile_is_not_asked_against(before):
    vehicle = Vehicle()
    vehicle.engagement.ask(vehicle.time, before)
    assert vehicle.tells("MANUAL") is State.IDLE
    assert "mode MANUAL" in vehicle.events.take()[-1].words
    assert vehicle.tells("OURS") is State.IDLE


@pytest.mark.parametrize("failsafe", [False, True])
def test_another_mode_ends_it_at_once_and_for_good(failsafe):
    vehicle = Vehicle().engaged()
    assert vehicle.tells("FBWA", failsafe=failsafe) is State.IDLE
    assert "mode FBWA" in vehicle.events.take()[-1].words
    assert vehicle.tells("OURS") is State.IDLE


def test_a_disarmed_vehicle_is_let_go():
    assert Vehicle().engaged().tells("OURS", armed=False) is State.IDLE


def test_a_failsafe_after_a_dead_link_is_waited_out():
    vehicle = Vehicle().engaged()
    assert vehicle.tells("HOLD", failsafe=True, silent=True, after=3.0) is State.SUSPENDED
    assert vehicle.tells("HOLD", failsafe=True) is State.SUSPENDED
    assert vehicle.tells("OURS") is State.ENGAGED


def test_a_pilot_who_takes_over_while_the_link_is_dead_keeps_the_aircraft():
    vehicle = Vehicle().engaged()
    assert vehicle.tells("MANUAL", failsafe=False, silent=True, after=3.0) is State.IDLE
    vehicle = Vehicle().engaged()
    vehicle.tells("HOLD", failsafe=True, silent=True, after=3.0)
    assert vehicle.tells("HOLD", failsafe=False) is State.IDLE
    assert vehicle.tells("OURS") is State.IDLE
    vehicle = Vehicle().engaged()
    vehicle.tells("OURS", failsafe=True)  # that of a low battery stands all the while
    assert vehicle.tells("MANUAL", failsafe=True, silent=True, after=3.0) is State.IDLE


def test_a_pilot_may_hand_over_by_the_mode_where_that_is_allowed():
    vehicle = Vehicle(by_mode=lambda: "")
    assert vehicle.tells("OURS") is State.IDLE  # nobody switched: it was found so
    vehicle.tells("LOITER")
    assert vehicle.tells("OURS") is State.ENGAGED


def test_a_pilot_who_hands_over_by_the_mode_hears_why_nothing_is_commanded():
    vehicle = Vehicle(by_mode=lambda: "no airspeed")
    vehicle.tells("LOITER")
    assert vehicle.tells("OURS") is State.IDLE
    assert [event.words for event in vehicle.events.take()] == [
        "not engaged by the mode: no airspeed"
    ]


def test_disengaged_is_said_once():
    vehicle = Vehicle().engaged()
    vehicle.events.take()
    vehicle.engagement.give_up("disengaged")
    vehicle.engagement.give_up("disengaged")
    assert [event.words for event in vehicle.events.take()] == [
        "disengaged; nothing is commanded until engaged again"
    ]
