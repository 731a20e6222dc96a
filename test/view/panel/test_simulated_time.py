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

from uav_tracking_mpc.view.panel.simulated_time import SimulatedTime
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR


@pytest.fixture
def simulated_time(panel):
    shown = panel(SimulatedTime)
    shown.until(lambda: "time" in shown.labels())
    return shown


@pytest.mark.parametrize(
    ("words", "request_"),
    [("Pause", ("pause", True)), ("Go on", ("pause", False)), ("Reset", ("reset",))],
)
def test_buttons(words, request_, simulated_time, flight):
    simulated_time.by_hand("time", words)
    simulated_time.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [request_]


def test_buttons_do_nothing_until_it_is_answered(simulated_time, flight):
    flight.steering.go_on.clear()
    simulated_time.by_hand("time", "Pause")
    simulated_time.until(lambda: flight.steering.asked)
    simulated_time.by_hand("time", "Reset")
    simulated_time.until(lambda: "asking for Pause" in simulated_time.text)
    flight.steering.go_on.set()
    simulated_time.until(lambda: "asking" not in simulated_time.text)
    assert flight.steering.asked == [("pause", True)]


def test_a_refused_button_says_why(simulated_time, flight):
    flight.steering.refusal = "time does not belong to this simulator"
    simulated_time.by_hand("time", "Pause")
    simulated_time.until(lambda: "time does not belong to this simulator" in simulated_time.text)


def test_speed(simulated_time, flight):
    simulated_time.by_hand("speed", "5 x")
    simulated_time.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", SIMULATOR, {"speed": 5.0})]


def test_a_speed_of_somebody_else_is_shown(simulated_time, flight):
    flight.steering.values[SIMULATOR]["speed"] = 3.0
    simulated_time.until(lambda: simulated_time.widget("speed").value == "3 x")


def test_it_says_whether_time_stands(simulated_time, flight):
    title = simulated_time.part.title
    simulated_time.until(lambda: f"{title}: stands still" in simulated_time.labels())
    flight.seen.append(sight(11.0))
    simulated_time.show()
    assert title in simulated_time.labels()


def test_it_is_absent_against_a_real_autopilot():
    flight = StandInFlight(steering=StandInSteering([CONTROLLER]))
    assert not SimulatedTime.fits(flight, StandInSource(flight))
