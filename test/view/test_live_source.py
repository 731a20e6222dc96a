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

"""What is heard is seen, silence is told in words, and requests reach the nodes."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from heard_flight import FIGURES, NOW, STATE, AnsweringNode, aircraft, nothing, report, said
from processes import DOMAIN, scripted

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.nodes.messages.conversions import position_from_point, set_truth
from uav_tracking_mpc.nodes.messages.heard_values import NodeReport
from uav_tracking_mpc.nodes.messages.named_figures import MODES
from uav_tracking_mpc.nodes.topics import TARGET_TRUTH
from uav_tracking_mpc.nodes.watching import Plan
from uav_tracking_mpc.view import live_source
from uav_tracking_mpc.view.live_source import (
    FAULTS,
    GONE,
    PAST_SPAN,
    STALE,
    LiveFlight,
    RosSteering,
    live_sight,
    node_statuses,
)
from uav_tracking_mpc.view.watched_flight import CONTROLLER, PAST_PERIOD, SILENT, SIMULATOR, TARGET


def seen(heard, before=None):
    return live_sight(heard, before, node_statuses(heard, NOW), NOW)


def test_a_flight_is_seen_as_it_is_heard():
    sight = seen(aircraft(report(**{"latency [s]": 0.02, "mode": "optimal plan"})))
    assert sight.time == 50.0
    np.testing.assert_array_equal(sight.position, STATE.position)
    assert sight.airspeed == 17.0
    assert sight.bank == pytest.approx(math.atan(0.2 * 17.0 / GRAVITY))  # to the right
    np.testing.assert_array_equal(sight.wind, [3.0, -4.0, 0.0])
    np.testing.assert_array_equal(sight.target.position, [10.0, 20.0, 1.0])
    np.testing.assert_array_equal(sight.target.velocity, [1.0, -2.0, 0.0])
    np.testing.assert_array_equal(sight.target.measured, [9.0, 19.0, 0.0])
    np.testing.assert_array_equal(sight.target.truth, [10.5, 20.5, 1.0])
    assert sight.target.std == 0.4
    np.testing.assert_array_equal(sight.wanted.centre, [10.0, 20.0, 121.0])
    assert sight.wanted.radius == pytest.approx(math.sqrt(300.0**2 - 120.0**2))
    assert sight.flown.radius == 275.0
    assert sight.errors["range_error"] == 5.0 and "mode" not in sight.errors
    assert (sight.mode, sight.reason) == (FallbackMode.OPTIMAL, "")
    assert (sight.cost, sight.solve_time, sight.latency) == (7.0, 1e-3, 0.02)


@pytest.mark.parametrize("late", [0.04, -0.04])
def test_the_target_is_where_it_is_at_the_time_of_the_state(late):
    """Otherwise its distance is another one than the error beside it says."""
    sight = seen(aircraft(report(), figures=said({**FIGURES, "stamp": STATE.stamp - late})))
    moved = np.array([1.0, -2.0, 0.0]) * late
    np.testing.assert_allclose(sight.target.position, np.array([10.0, 20.0, 1.0]) + moved)
    np.testing.assert_allclose(sight.wanted.centre, np.array([10.0, 20.0, 121.0]) + moved)
    elsewhen = seen(aircraft(figures=said({**FIGURES, "stamp": STATE.stamp - 1000.0 * late})))
    np.testing.assert_array_equal(elsewhen.target.position, [10.0, 20.0, 1.0])


def test_of_the_plan_what_is_not_yet_flown_is_seen():
    np.testing.assert_array_equal(seen(aircraft()).plan, np.arange(6.0, 15.0).reshape(3, 3))
    placeless = Plan(49.9, np.empty((0, 3)), np.empty(0))
    assert seen(aircraft(plan=said(placeless))).plan is None


def test_before_the_first_state_nothing_is_seen():
    assert seen(aircraft(state=nothing())) is None


def test_without_a_controller_aircraft_wind_and_target_are_seen():
    quiet = dict.fromkeys(("plan", "orbit", "figures", "cost", "solve_time"), nothing())
    sight = seen(aircraft(**quiet))
    assert (sight.mode, sight.reason) == (None, "")
    np.testing.assert_allclose(sight.wind, [3.0, 4.0, 0.0])  # of the wind triangle
    np.testing.assert_array_equal(sight.target.position, [9.0, 19.0, 0.0])  # as measured
    assert math.isnan(sight.target.std)
    assert sight.wanted is None and sight.flown is None and not sight.errors
    assert math.isnan(sight.cost)
    assert seen(aircraft(**quiet, airspeed=nothing())).wind is None


def test_a_controller_that_waits_says_why():
    waits = report(mode="silence", **{"mode reason": "no target position"})
    sight = seen(aircraft(waits, plan=nothing(), figures=nothing()))
    assert (sight.mode, sight.reason) == (None, "no target position")


def test_commands_that_end_are_a_silence_in_words():
    killed = aircraft(report(0.5, mode="optimal plan"), plan=said(None, STALE + 1.5))
    assert seen(killed).mode is FallbackMode.SILENCE
    assert seen(killed).reason == "nothing comes on uav/command for 3 s"
    stopped = report(0.5, mode="silence", **{"mode reason": "deactivated"})
    sight = seen(aircraft(stopped, plan=said(None, STALE + 1.5)))
    assert (sight.mode, sight.reason) == (FallbackMode.SILENCE, "deactivated")


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode is not FallbackMode.SILENCE])
def test_the_mode_is_that_of_the_command_and_the_reason_that_of_the_report(mode):
    figures = said({**FIGURES, "mode": float(MODES.index(mode))})
    worse = report(mode="loiter law", **{"mode reason": "target position is lost"})
    sight = seen(aircraft(worse, figures=figures))
    assert sight.mode is mode
    assert sight.reason == ("target position is lost" if mode is FallbackMode.LOITER else "")


def test_without_a_target_the_mode_is_that_of_the_report():
    level = report(mode="wings level", **{"mode reason": "no target position"})
    sight = seen(aircraft(level, figures=nothing()))
    assert (sight.mode, sight.reason) == (FallbackMode.HOLD, "no target position")


def test_an_aircraft_that_falls_silent_stays_where_it_was():
    before = seen(aircraft())
    sight = seen(aircraft(state=said(STATE, STALE + 1.5)), before)
    np.testing.assert_array_equal(sight.position, STATE.position)
    assert sight.mode is FallbackMode.SILENCE
    assert sight.reason == "nothing comes on uav/odometry for 3 s"
    assert sight.plan is None and sight.flown is None


def test_while_time_stands_still_the_controller_says_so():
    stands = report(words="simulated time stands still", mode="optimal plan")
    sight = seen(aircraft(stands, state=said(STATE, STALE + 1.5)), seen(aircraft()))
    assert (sight.mode, sight.reason) == (FallbackMode.OPTIMAL, "simulated time stands still")


def test_a_state_that_cannot_be_used_is_told():
    bad = SimpleNamespace(value=None, arrival=NOW, trouble="uav/odometry: pose.orientation")
    sight = seen(aircraft(state=bad), seen(aircraft()))
    assert (sight.mode, sight.reason) == (FallbackMode.SILENCE, "uav/odometry: pose.orientation")


def test_a_node_that_says_no_more_is_silent():
    heard = aircraft(report(0.5), report(GONE + 1.0, node="uav_simulator", words="flying"))
    controller, simulator = node_statuses(heard, NOW)
    assert (controller.level, controller.words) == (1, "fine")
    assert (simulator.level, simulator.words) == (SILENT, "silent, before: flying")


@pytest.mark.parametrize("values", [{"mode": "sideways"}, {"latency [s]": "long"}, {}])
def test_reports_of_others_are_survived(values):
    strange = NodeReport("", "nmpc_controller", 0, "", {**values, "orbit range [m]": "wide"}, NOW)
    sight = seen(aircraft(strange))
    assert sight.wanted is None and math.isnan(sight.latency)
    assert sight.mode is FallbackMode.OPTIMAL


SHORT = "parameter 'range' is 20.0, must be at least 40 m: the bank limit"
DONE = SimpleNamespace(success=True, message="done")


@pytest.fixture
def node():
    """All three nodes of one of several aircraft."""
    node = AnsweringNode("/uav1")
    values = {"range": 300.0, "direction": "nearest", "autostart": True, "horizon": 20}
    node.own(CONTROLLER, values, lambda wanted: SHORT if wanted.get("range") == 20.0 else "")
    node.own(SIMULATOR, {"wind": [0.0, 0.0, 0.0]})
    node.target = {"motion": "circle", "position": [0.0, 0.0, 0.0]}
    node.own(TARGET, node.target)
    return node


@pytest.fixture
def steering(node):
    return RosSteering(node, "uav1")


def tell_truth(node, position):
    message = TARGET_TRUTH.type()
    set_truth(message, 0, np.array(position), np.zeros(3))
    node.heard["/uav1/target/truth"](message)


def test_only_who_is_there_is_steered(node, steering):
    assert steering.nodes == {CONTROLLER, SIMULATOR, TARGET}
    for owner in (SIMULATOR, TARGET):  # as with a real autopilot and a tracker
        node.answers = {k: v for k, v in node.answers.items() if owner not in k}
    steering = RosSteering(node, "/uav1/")
    assert steering.nodes == {CONTROLLER}
    assert steering.change(SIMULATOR, wind=(1.0, 0.0, 0.0)) == "uav_simulator is not there"
    assert steering.pause(True) == "uav_simulator is not there"
    assert steering.reset() == "uav_simulator is not there"
    assert steering.parameters(SIMULATOR) == {}


def test_aircraft_of_another_namespace_are_not_asked(node):
    assert RosSteering(node, "uav2").nodes == frozenset()
    assert RosSteering(node, "").nodes == frozenset()


def test_parameters_are_read_and_changed(steering):
    found = steering.parameters(CONTROLLER)
    assert found == {"range": 300.0, "direction": "nearest", "autostart": True, "horizon": 20}
    assert steering.change(CONTROLLER, range=350.0, direction="clockwise", horizon=22) == ""
    assert steering.parameters(CONTROLLER)["range"] == 350.0
    assert steering.parameters(CONTROLLER)["direction"] == "clockwise"
    for wind in ((6, 0.0, 0), np.array([6.0, 0.0, 0.0])):  # as sliders and arrays give them
        assert steering.change(SIMULATOR, wind=wind) == ""
        assert list(steering.parameters(SIMULATOR)["wind"]) == [6.0, 0.0, 0.0]
    assert steering.change(CONTROLLER, range=np.float64(320.0)) == ""
    assert steering.parameters(CONTROLLER)["range"] == 320.0


def test_a_refusal_is_the_nodes_own_words(steering):
    assert steering.change(CONTROLLER, range=20.0, direction="clockwise") == SHORT
    assert steering.parameters(CONTROLLER)["direction"] == "nearest"


def test_a_node_that_does_not_answer_is_a_refusal(node, steering):
    node.offer("nmpc_controller/engage", lambda request: DONE)
    assert steering.engage(False) == ""
    node.fall_silent(CONTROLLER)
    words = "nmpc_controller did not answer within 5 s"
    assert steering.change(CONTROLLER, range=350.0) == words
    assert steering.engage(True) == words
    assert steering.parameters(CONTROLLER) == {}
    assert steering.change(SIMULATOR, wind=(1.0, 0.0, 0.0)) == ""  # the others are as before


def test_services_are_called_as_asked_and_refuse_in_their_own_words(node, steering):
    asked = []

    def answered(request):
        asked.append(getattr(request, "data", None))
        return DONE

    for service in ("nmpc_controller/engage", "uav_simulator/pause", "uav_simulator/reset"):
        node.offer(service, answered)
    answers = [steering.engage(False), steering.pause(True), steering.pause(False)]
    assert [*answers, steering.reset()] == ["", "", "", ""]
    assert asked == [False, True, False, None]
    words = "time is the wall's and cannot be stopped"
    node.offer("uav_simulator/pause", lambda request: SimpleNamespace(success=False, message=words))
    assert steering.pause(True) == words


def test_the_target_is_sent_at_the_height_that_it_has(node, steering):
    assert steering.send_target(10.0, 20.0) == "target_publisher has not told where the target is"
    tell_truth(node, (1.0, 2.0, 30.0))
    assert steering.send_target(10.0, 20.0) == ""
    ((topic, message),) = node.published
    assert topic == "/uav1/target/goal"
    np.testing.assert_array_equal(position_from_point(message), [10.0, 20.0, 30.0])
    assert node.target == {"motion": "stationary", "position": [10.0, 20.0, 30.0]}


def test_a_goal_that_is_not_taken_is_told(node, steering):
    tell_truth(node, (0.0, 0.0, 0.0))
    assert "must be finite" in steering.send_target(math.nan, 0.0)
    assert node.published == []
    words = "parameter 'position' is [2e+06, 0, 0], must be a list of 3 numbers"
    node.own(TARGET, node.target, lambda wanted: words)
    assert steering.send_target(2e6, 0.0) == words
    node.fall_silent(TARGET)
    assert steering.send_target(1.0, 0.0) == "target_publisher did not answer within 5 s"


def test_faults_are_those_that_are_offered(node, steering):
    assert steering.faults == {}
    assert steering.inject("controller killed") == (
        "fault 'controller killed' is not offered here; offered: none"
    )
    called = []

    def answer(service):
        return lambda request: called.append(service) or DONE

    for service, _ in FAULTS.values():
        node.offer(service, answer(service))
    assert list(steering.faults) == ["target lost", "state lost", "controller killed"]
    assert [steering.inject(fault) for fault in steering.faults] == ["", "", ""]
    assert called == [service for service, _ in FAULTS.values()]
    assert "offered: target lost, state lost" in steering.inject("meteorite")


@pytest.fixture
def flight(monkeypatch):
    """A flight, and what makes it fly on to a time in [s]."""
    heard, known = aircraft(), SimpleNamespace(value=None)
    monkeypatch.setattr(live_source, "RosSteering", lambda node, namespace: None)
    watcher = SimpleNamespace(aircraft={"/fleet/red": heard}, parameters={"/fleet/red": known})
    live, now = LiveFlight(watcher, "/fleet/red"), [1000.0]
    monkeypatch.setattr(live_source.time, "monotonic", lambda: now[0])

    def fly(stamp):
        heard.state.value = replace(STATE, stamp=stamp)
        return live.sight

    return SimpleNamespace(live=live, fly=fly, known=known)


def test_its_name_is_one_word(flight):
    assert flight.live.name == "fleet.red"


def test_its_parameters_are_those_of_its_controller(flight):
    assert flight.live.tracking is None
    flight.known.value = parameters = object()
    assert flight.live.tracking is parameters


def test_the_past_is_thin_and_without_plans(flight):
    for stamp in np.arange(0.0, 10.0, 0.02):
        flight.fly(stamp)
    past = flight.live.past(4.0)
    times = np.array([sight.time for sight in past])
    assert np.all(np.diff(times) >= PAST_PERIOD - 1e-9)
    assert np.all(np.diff(times) < 2.0 * PAST_PERIOD)
    assert 3.5 < times[-1] - times[0] <= 4.0
    assert all(sight.plan is None and not sight.statuses for sight in past)
    assert flight.live.sight.plan is not None


def test_the_past_does_not_grow_without_end(flight):
    for stamp in np.arange(0.0, 3.0 * PAST_SPAN, PAST_PERIOD):
        flight.fly(stamp)
    assert len(flight.live.past(np.inf)) == round(PAST_SPAN / PAST_PERIOD)


def test_when_time_begins_anew_the_past_does(flight):
    for stamp in (10.0, 20.0, 5.0, 6.0):
        flight.fly(stamp)
    assert [sight.time for sight in flight.live.past(np.inf)] == [5.0, 6.0]


# In a process of its own, as the page is: that of the tests holds the participants of many others.
WATCHER = """
import threading, time
import numpy as np
import rclpy
from uav_tracking_mpc.nodes.messages.conversions import set_odometry
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.view.live_source import LiveSource

domain = int(sys.argv[1])
source = LiveSource(domain)
assert source.flights() == []
assert source.words == f"waiting for a flight in domain {domain}"
context = rclpy.Context()
context.init(args=[], domain_id=domain)
sender = rclpy.create_node("sender", namespace="red", context=context)
states = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
message, deadline = ODOMETRY.type(), time.monotonic() + 60.0
while source.words and time.monotonic() < deadline:
    set_odometry(message, 1_000_000_000, np.array([1.0, 2.0, 3.0, 0.0, 0.0, 20.0]), np.zeros(3))
    states.publish(message)
    time.sleep(0.05)
words, (flight,) = source.words, source.flights()
same, name, position = source.flights()[0] is flight, flight.name, flight.sight.position
source.close()
left = {"flight_watcher", "past of flights"} & {t.name for t in threading.enumerate()}
sender.destroy_node()
context.try_shutdown()
assert (words, same, name, list(position), left) == ("", True, "red", [1.0, 2.0, 3.0], set())
"""


@pytest.mark.nodes
def test_a_source_waits_until_something_flies_and_ends():
    code, _, errors = scripted(WATCHER, DOMAIN)
    assert code == 0, errors
