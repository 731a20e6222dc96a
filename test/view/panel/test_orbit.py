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
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering

from uav_tracking_mpc.view.panel.orbit import Orbit
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR

RANGE = "range [m]"


@pytest.fixture
def orbit(panel):
    shown = panel(Orbit)
    shown.until(lambda: RANGE in shown.labels())
    return shown


def test_sliders_stand_at_what_is_flown(orbit):
    values = [orbit.widget(label).value for label in (RANGE, "altitude [m]", "airspeed [m/s]")]
    assert values == [300.0, 120.0, 22.0]
    assert orbit.widget("direction").value == "nearest"


def test_spans_are_those_of_the_flight(orbit):
    airspeed = orbit.widget("airspeed [m/s]")
    assert (airspeed.min, airspeed.max) == (14.0, 32.0)
    assert orbit.widget(RANGE).min < 120.0 < 300.0 < orbit.widget(RANGE).max


def test_a_slider_asks_for_its_parameter_once_it_rests(orbit, flight):
    for value in (310.0, 330.0, 350.0):
        orbit.by_hand(RANGE, value)
    orbit.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", CONTROLLER, {"range": 350.0})]
    orbit.until(lambda: "asking" not in orbit.text)
    assert orbit.widget(RANGE).value == 350.0


def test_a_refusal_stands_on_the_page_and_the_slider_goes_back(orbit, flight):
    flight.steering.refusal = "parameters 'range', 'altitude': range is 100 m <below> the altitude"
    orbit.by_hand(RANGE, 100.0)
    orbit.until(lambda: "refused" in orbit.text)
    orbit.until(lambda: orbit.widget(RANGE).value == 300.0)
    assert "range is 100 m &lt;below&gt; the altitude" in orbit.text
    flight.steering.refusal = ""
    orbit.by_hand(RANGE, 350.0)
    orbit.until(lambda: len(flight.steering.asked) == 2 and "refused" not in orbit.text)


def test_sliders_follow_somebody_else(orbit, flight):
    flight.steering.values[CONTROLLER] |= {"range": 5000.0, "direction": "clockwise"}
    orbit.until(lambda: orbit.widget(RANGE).value == 5000.0)
    assert orbit.widget(RANGE).max >= 5000.0
    assert orbit.widget("direction").value == "clockwise"
    assert flight.steering.asked == []


def test_while_it_is_asked_the_page_says_so_and_goes_on(orbit, flight):
    flight.steering.go_on.clear()
    orbit.by_hand("direction", "clockwise")
    orbit.until(lambda: "asking for direction clockwise" in orbit.text)
    orbit.show()
    assert orbit.widget("direction").value == "clockwise"
    flight.steering.go_on.set()
    orbit.until(lambda: "asking" not in orbit.text)


def test_an_exception_becomes_a_notification(orbit, flight):
    flight.steering.failure = RuntimeError("the service is gone")
    flight.steering.go_on.clear()
    orbit.by_hand(RANGE, 350.0)
    orbit.until(lambda: flight.steering.asked and orbit.part.client)
    flight.steering.go_on.set()
    orbit.until(lambda: orbit.client.notifications)
    ((title, body),) = orbit.client.notifications
    assert "range 350" in title
    assert body == "RuntimeError: the service is gone"
    orbit.until(lambda: orbit.widget(RANGE).value == 300.0)


def test_parameters_that_nobody_answers_are_waited_for(panel, flight):
    answers = flight.steering.values.pop(CONTROLLER)
    shown = panel(Orbit)
    assert "waiting for the parameters of nmpc_controller" in shown.show()
    flight.steering.values[CONTROLLER] = answers
    shown.until(lambda: RANGE in shown.labels())
    assert "waiting" not in shown.text


def test_it_is_absent_without_a_controller_to_steer():
    for steering in (None, StandInSteering([SIMULATOR])):
        flight = StandInFlight(steering=steering)
        assert not Orbit.fits(flight, StandInSource(flight))
