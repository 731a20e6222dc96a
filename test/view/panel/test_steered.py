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

"""What is steered: requests are made once, refusals are shown, widgets follow what is flown."""

import math
import threading
import time

import numpy as np
import pytest
from processes import PATIENCE as WAIT
from processes import wait_for
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering, sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.motions import TARGET_MOTION
from uav_tracking_mpc.view.panel import _steering_part
from uav_tracking_mpc.view.panel._steering_part import Requests, requests_of
from uav_tracking_mpc.view.panel.steered import (
    PATIENCE,
    Compare,
    Engagement,
    Faults,
    Orbit,
    SimulatedTime,
    Target,
    Wind,
    from_where,
)
from uav_tracking_mpc.view.simulated_source import SimulatedFlight
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SIMULATOR,
    TARGET,
    PlayClock,
    RivalSight,
)


def asked(requests, request):
    """Event of the answer to a request that has begun."""
    answered = threading.Event()
    requests.begin(request, lambda words, kind: answered.set())
    return answered


def test_one_at_a_time():
    steering = StandInSteering()
    requests = Requests(steering)
    steering.go_on.clear()
    events = [asked(requests, lambda: steering.pause(True)), asked(requests, steering.reset)]
    assert wait_for(lambda: steering.asked)
    time.sleep(0.1)  # in which a second one would begin
    assert len(steering.asked) == 1
    steering.go_on.set()
    assert all(event.wait(WAIT) for event in events)
    assert len(steering.asked) == 2


def test_all_parts_share_those_of_an_aircraft():
    one, another = StandInSteering(), StandInSteering()
    assert requests_of(one) is requests_of(one)
    assert requests_of(one) is not requests_of(another)


def test_parameters_are_not_waited_for():
    steering = StandInSteering()
    requests = Requests(steering)
    assert wait_for(lambda: requests.parameters(CONTROLLER))
    assert requests.parameters(CONTROLLER)["range"] == 300.0


def test_an_answer_of_before_a_change_is_not_believed():
    """A node that was asked before a change and answers after it tells what was."""
    steering = StandInSteering()
    requests, before, answers = Requests(steering), dict(steering.values[CONTROLLER]), []
    asked_, go_on = threading.Event(), threading.Event()

    def slowly(node):
        asked_.set()
        go_on.wait()
        answers.append(node)
        return before

    steering.parameters = slowly
    requests.parameters(CONTROLLER)
    assert asked_.wait(WAIT)
    assert requests.change(CONTROLLER, {"range": 350.0}) == ""
    go_on.set()
    assert wait_for(lambda: answers)
    steering.parameters = lambda node: dict(steering.values[node])
    assert wait_for(lambda: requests._polled[CONTROLLER] != float("inf"))
    assert requests._known[CONTROLLER]["range"] == 350.0


RANGE = "range [m]"
LAST_WIDGET = {Orbit: RANGE, Target: "motion", Wind: "wind [m/s]", SimulatedTime: "time"}


@pytest.fixture
def begun(panel, flight):
    """A part whose parameters are known; wind blows from the north."""
    flight.steering.values[SIMULATOR]["wind"] = (0.0, -8.0, 0.5)

    def begin(part):
        shown = panel(part)
        shown.until(lambda: LAST_WIDGET.get(part, "commands") in shown.labels())
        return shown

    return begin


@pytest.fixture
def orbit(begun):
    return begun(Orbit)


@pytest.fixture
def wind(begun):
    return begun(Wind)


@pytest.mark.parametrize(
    ("part", "by_hand", "asked"),
    [
        (Orbit, {"direction": "clockwise"}, ("change", CONTROLLER, {"direction": "clockwise"})),
        (
            Target,
            {"motion": "circle", "speed [m/s]": 5.0},
            ("change", TARGET, {"motion": "circle", "speed": 5.0}),
        ),
        (
            Wind,
            {"wind [m/s]": 10.0, "from [deg]": 90.0},
            ("change", SIMULATOR, {"wind": (-10.0, 0.0, 0.5)}),
        ),
        (Wind, {"gusts [m/s]": 7.5}, ("change", SIMULATOR, {"gust_intensity": 7.5})),
        (SimulatedTime, {"speed": "5 x"}, ("change", SIMULATOR, {"speed": 5.0})),
        (SimulatedTime, {"time": "Pause"}, ("pause", True)),
        (SimulatedTime, {"time": "Go on"}, ("pause", False)),
        (SimulatedTime, {"time": "Reset"}, ("reset",)),
        (Engagement, {"commands": "Engage"}, ("engage", True)),
        (Engagement, {"commands": "Disengage"}, ("engage", False)),
    ],
)
def test_what_is_set_by_hand_is_asked_for_at_once(begun, flight, part, by_hand, asked):
    shown = begun(part)
    for label, value in by_hand.items():
        shown.by_hand(label, value)
    shown.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [asked]


@pytest.mark.parametrize(
    ("part", "nodes"),
    [
        (Orbit, None),
        (Orbit, [SIMULATOR]),
        (Target, [CONTROLLER]),  # of a tracker
        (Wind, [CONTROLLER]),  # against a real autopilot
        (SimulatedTime, [CONTROLLER]),
        (Engagement, None),  # of a record
        (Faults, None),
        (Faults, [CONTROLLER]),  # which offers none
        (Compare, None),
        (Compare, [CONTROLLER]),  # that flies elsewhere
    ],
)
def test_a_part_is_absent_where_there_is_nobody_to_ask(part, nodes):
    flight = StandInFlight(steering=None if nodes is None else StandInSteering(nodes))
    if nodes is not None:
        flight.steering.faults, flight.steering.comparable = {}, False
    assert not part.fits(flight, StandInSource(flight))


def test_without_air_there_is_no_wind_to_steer(panel, flight):
    """The plant of ``paper`` refuses every wind in flight."""
    for name, plant in (("paper", "euler"), ("small_uav", "vehicle")):
        simulated = SimulatedFlight(load_configuration(name), PlayClock(0.0, math.inf))
        assert simulated.steering.parameters(SIMULATOR)["plant"] == plant
    flight.steering.values[SIMULATOR]["plant"] = "euler"
    airless = panel(Wind)
    airless.until(lambda: not airless.part.folder.visible)
    assert flight.steering.asked == []


@pytest.mark.parametrize(
    ("part", "shown"),
    [
        (Orbit, {RANGE: 300.0, "altitude [m]": 120.0, "airspeed [m/s]": 22.0}),
        (Orbit, {"direction": "nearest"}),
        (Wind, {"wind [m/s]": 8.0, "from [deg]": 0.0}),
        (Target, {"motion": "stationary"}),
    ],
)
def test_widgets_begin_at_what_is_flown(begun, part, shown):
    widgets = begun(part)
    assert {label: widgets.widget(label).value for label in shown} == shown


@pytest.mark.parametrize(
    ("part", "node", "values", "shown"),
    [
        (Orbit, CONTROLLER, {"range": 5000.0}, {RANGE: 5000.0}),
        (Orbit, CONTROLLER, {"direction": "clockwise"}, {"direction": "clockwise"}),
        (Target, TARGET, {"motion": "my_motion.py:Mine"}, {"motion": "my_motion.py:Mine"}),
        (Target, TARGET, {"speed": 40.0}, {"speed [m/s]": 40.0}),
        (SimulatedTime, SIMULATOR, {"speed": 3.0}, {"speed": "3 x"}),
    ],
)
def test_widgets_follow_somebody_else(begun, flight, part, node, values, shown):
    """Also beyond what they spanned, and to what was none of their options."""
    widgets = begun(part)
    flight.steering.values[node] |= values
    widgets.until(lambda: {label: widgets.widget(label).value for label in shown} == shown)
    assert flight.steering.asked == []


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


def test_a_refusal_stands_where_the_value_was_set(orbit, flight):
    flight.steering.refusal = "range is 100 m"
    orbit.by_hand(RANGE, 100.0)
    orbit.until(lambda: "refused" in orbit.text)
    (line,) = (h for h in orbit._handles() if "refused" in getattr(h, "content", ""))
    assert orbit.widget(RANGE).order < line.order < orbit.widget("altitude [m]").order


def test_a_slider_that_a_hand_moves_waits_though_another_value_is_refused(
    orbit, flight, monkeypatch
):
    flight.steering.refusal = "range is 100 m"
    flight.steering.go_on.clear()
    orbit.by_hand(RANGE, 100.0)
    orbit.until(lambda: flight.steering.asked)
    monkeypatch.setattr(_steering_part, "REST", 1e9)
    orbit.by_hand("altitude [m]", 200.0)
    orbit.show()
    flight.steering.go_on.set()
    orbit.until(lambda: "refused" in orbit.text)
    orbit.show()
    assert [each.widget.label for each in orbit.part._steered if each.wanted] == ["altitude [m]"]


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


def test_every_motion_is_listed(begun):
    assert set(begun(Target).widget("motion").options) == set(TARGET_MOTION.names)


@pytest.mark.parametrize(
    ("blows_to", "speed", "azimuth"),
    [((0.0, -8.0, 0.0), 8.0, 0.0), ((-3.0, 0.0, 0.0), 3.0, 90.0), ((5.0, 5.0, 0.0), 7.071, 225.0)],
)
def test_wind_is_told_by_where_it_comes_from(blows_to, speed, azimuth):
    assert from_where(blows_to) == pytest.approx((speed, azimuth), abs=1e-3)


@pytest.mark.parametrize(("azimuth", "speed"), [(270.0, 0.0), (360.0, 5.0)])
def test_a_direction_stays_where_the_wind_has_none_and_at_the_northern_end(
    wind, flight, azimuth, speed
):
    wind.by_hand("from [deg]", azimuth)
    wind.by_hand("wind [m/s]", speed)
    wind.until(lambda: flight.steering.values[SIMULATOR]["wind"] == (0.0, -speed + 0.0, 0.5))
    wind.until(lambda: "asking" not in wind.text)
    wind.part._touched = float("-inf")  # nobody has touched it for long
    wind.show()
    assert wind.widget("from [deg]").value == azimuth


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_a_number_that_is_not_finite_is_refused_and_the_slider_goes_on(wind, flight, number):
    wind.by_hand("from [deg]", number)
    assert f"from [deg] cannot be {number}" in wind.show()
    assert wind.widget("from [deg]").value == 0.0
    wind.by_hand("from [deg]", 90.0)
    wind.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", SIMULATOR, {"wind": (-8.0, 0.0, 0.5)})]


def test_a_choice_that_there_is_not_is_refused_and_the_list_goes_on(orbit, flight):
    orbit.by_hand("direction", "upside down")
    assert "direction cannot be upside down" in orbit.show()
    assert orbit.widget("direction").value == "nearest"
    orbit.by_hand("direction", "clockwise")
    orbit.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", CONTROLLER, {"direction": "clockwise"})]


@pytest.fixture
def simulated_time(begun):
    return begun(SimulatedTime)


def test_buttons_do_nothing_until_it_is_answered(simulated_time, flight):
    flight.steering.go_on.clear()
    simulated_time.by_hand("time", "Pause")
    simulated_time.until(lambda: flight.steering.asked)
    simulated_time.by_hand("time", "Reset")
    simulated_time.until(lambda: "asking for Pause" in simulated_time.text)
    flight.steering.go_on.set()
    simulated_time.until(lambda: "asking" not in simulated_time.text)
    assert flight.steering.asked == [("pause", True)]


def test_it_says_whether_time_stands(simulated_time, flight):
    title = simulated_time.part.title
    simulated_time.until(lambda: f"{title}: stands still" in simulated_time.labels())
    simulated_time.show(sight(11.0))
    assert title in simulated_time.labels()


def test_a_button_that_there_is_not_does_nothing(panel, flight, capfd):
    shown = panel(Engagement)
    shown.by_hand("commands", "no such button")
    shown.by_hand("commands", "Engage")
    shown.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("engage", True)]
    assert capfd.readouterr().err == ""


FAULT = "lose the target"


@pytest.fixture
def faults(panel, flight):
    return panel(Faults).shown()


def inject(faults, flight):
    faults.by_hand("inject", FAULT)
    faults.until(lambda: "no fallback so far" in faults.text)
    assert flight.steering.asked == [("inject", FAULT)]


def test_what_a_fault_does_is_said_before(faults):
    assert "No target position arrives for 10 s." in faults.widget("inject").hint


def test_a_fault_its_fallback_and_its_recovery(faults, flight):
    inject(faults, flight)
    text = faults.show(sight(14.0, mode=FallbackMode.LOITER, reason="target position is lost"))
    assert "loiter law" in text
    assert "target position is lost" in text
    text = faults.show(sight(21.0, mode=FallbackMode.LOITER), sight(23.0), sight(40.0))
    assert "recovered" in text
    assert "after 11 s" in text


def test_a_fault_that_needs_no_fallback(faults, flight):
    inject(faults, flight)
    assert "no fallback was needed" in faults.show(sight(10.0 + 2.0 * PATIENCE))


def test_a_fallback_after_the_recovery_is_none_of_its_story(faults, flight):
    inject(faults, flight)
    faults.show(sight(14.0, mode=FallbackMode.LOITER), sight(15.0))
    text = faults.show(sight(60.0, mode=FallbackMode.SILENCE, reason="disengaged"))
    assert "recovered" in text
    assert "disengaged" not in text
    faults.by_hand("inject", FAULT)
    faults.until(lambda: "disengaged" in faults.text)  # a new fault begins a new story


def test_a_fault_that_is_offered_later_gets_its_button(faults, flight):
    flight.steering.faults["lose the state"] = "No state arrives for 3 s."
    faults.show()
    assert "No state arrives for 3 s." in faults.widget("inject").hint
    faults.by_hand("inject", "lose the state")
    faults.until(lambda: flight.steering.asked == [("inject", "lose the state")])


def test_a_refused_fault_tells_no_story(faults, flight):
    flight.steering.refusal = "a fault is under way"
    faults.by_hand("inject", FAULT)
    faults.until(lambda: "a fault is under way" in faults.text)
    assert "fallback" not in faults.text


def test_a_fallback_that_is_over_before_the_answer_comes_is_told(faults, flight):
    flight.steering.go_on.clear()
    faults.by_hand("inject", FAULT)
    faults.until(lambda: flight.steering.asked)
    lost = {"mode": FallbackMode.LOITER}
    faults.show(sight(14.0, **lost), sight(21.0, **lost), sight(23.0))
    flight.steering.go_on.set()
    faults.until(lambda: "recovered" in faults.text)
    assert "after 11 s" in faults.text


@pytest.mark.parametrize(("lost", "after"), [(11.0, 12.0), (500.0, 1.0)], ids=["fault", "reset"])
def test_a_fallback_before_a_fault_or_a_reset_is_none_of_its_story(faults, flight, lost, after):
    faults.show(sight(lost, mode=FallbackMode.LOITER), sight(after))
    inject(faults, flight)


BOX = "classical laws"


def beside(time, ours, theirs):
    rival = RivalSight("l1", np.zeros(3), 0.0, 0.0, 0.0, theirs)
    return sight(time, errors={"range_error": ours}, rivals=(rival,))


def test_they_are_asked_for_by_a_box(panel, flight):
    shown = panel(Compare)
    for on in (True, False):
        shown.by_hand(BOX, on)
        shown.until(lambda: "asking" not in shown.text)
    assert flight.steering.asked == [("compare", True), ("compare", False)]


def test_the_box_tells_what_is_flown_though_it_was_refused(panel, flight):
    shown, flight.steering.refusal = panel(Compare), "the simulation has ended"
    shown.by_hand(BOX, True)
    shown.until(lambda: "has ended" in shown.text and not shown.widget(BOX).value)
    assert flight.steering.asked == [("compare", True)]


def test_errors_of_now_and_of_the_last_minute(panel, flight):
    flight.seen = [sight(0.0)]
    shown = panel(Compare).shown(beside(10.0, 3.0, 40.0), beside(11.0, 4.0, 30.0))
    rows = shown.text.split("<tr")
    assert "+4.0" in rows[-2] and "3.5" in rows[-2]
    assert "l1" in rows[-1] and "+30.0" in rows[-1] and "35.4" in rows[-1]
    assert "l1" not in shown.show(sight(12.0))
