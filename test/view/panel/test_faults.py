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

import pytest
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.panel.faults import PATIENCE, Faults

FAULT = "lose the target"


@pytest.fixture
def faults(panel, flight):
    shown = panel(Faults)
    shown.show()
    return shown


def inject(faults, flight):
    faults.by_hand(FAULT, True)
    faults.until(lambda: "no fallback so far" in faults.text)
    assert flight.steering.asked == [("inject", FAULT)]


def test_what_a_fault_does_is_said_before(faults):
    assert "No target position arrives for 10 s." in faults.text


def test_a_fault_its_fallback_and_its_recovery(faults, flight):
    inject(faults, flight)
    flight.seen.append(sight(14.0, mode=FallbackMode.LOITER, reason="target position is lost"))
    text = faults.show()
    assert "loiter law" in text
    assert "target position is lost" in text
    flight.seen.append(sight(21.0, mode=FallbackMode.LOITER))
    faults.show()
    flight.seen.append(sight(23.0))
    faults.show()
    flight.seen.append(sight(40.0))
    text = faults.show()
    assert "recovered" in text
    assert "after 11 s" in text


def test_no_fault_begins_while_one_is_asked_for(faults, flight):
    flight.steering.go_on.clear()
    faults.by_hand(FAULT, True)
    faults.until(lambda: faults.widget(FAULT).disabled)
    assert f"asking for {FAULT}" in faults.text
    flight.steering.go_on.set()
    faults.until(lambda: not faults.widget(FAULT).disabled)


def test_a_fault_that_needs_no_fallback(faults, flight):
    inject(faults, flight)
    flight.seen.append(sight(10.0 + 2.0 * PATIENCE))
    assert "no fallback was needed" in faults.show()


def test_a_fault_that_is_offered_later_gets_its_button(faults, flight):
    flight.steering.faults["lose the state"] = "No state arrives for 3 s."
    assert "No state arrives for 3 s." in faults.show()
    assert "lose the state" in faults.labels()


def test_a_refused_fault_tells_no_story(faults, flight):
    flight.steering.refusal = "a fault is under way"
    faults.by_hand(FAULT, True)
    faults.until(lambda: "a fault is under way" in faults.text)
    assert "fallback" not in faults.text


def test_it_is_absent_where_nothing_can_be_injected():
    steering = StandInSteering()
    steering.faults = {}
    for flight in (StandInFlight(), StandInFlight(steering=steering)):
        assert not Faults.fits(flight, StandInSource(flight))
