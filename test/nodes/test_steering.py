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

"""Parameters and steering in flight."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from node_flight import Flight
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.nodes.messages.conversions import set_point
from uav_tracking_mpc.nodes.messages.target_messages import truth_from_odometry
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH

pytestmark = pytest.mark.nodes


@pytest.fixture
def flight():
    flight = Flight()
    yield flight
    flight.end()


def test_another_orbit_is_flown_without_a_jump(flight):
    flight.add_all()
    assert flight.commanded(40)
    assert flight.spin(lambda: flight.told()[1].get("mode") == "optimal plan")
    begin = len(flight.commands)
    assert flight.set(range=340.0, altitude=140.0).successful
    assert flight.controller.parameters.orbit.range == 340.0
    assert flight.commanded(60)
    steps = np.abs(np.diff(flight.inputs()[begin - 1 :], axis=0))
    # Full bank the other way is what the new orbit asks for: half a second is spent on it.
    limit = flight.controller.parameters.envelope.turn_rate_max(22.0)
    assert np.max(steps[:, 0]) < 0.5 * limit
    assert np.max(steps[:, 1]) < 0.25
    assert np.max(steps[:, 2]) < 2.5
    assert flight.told()[1]["mode"] == "optimal plan"
    # It climbs and widens.
    assert flight.spin(lambda: flight.states[-1].pose.pose.position.z > 125.0)


def test_what_is_refused_leaves_everything_as_it_was(flight):
    flight.add_all()
    assert flight.commanded()
    before, orbit = flight.controller.parameters, flight.controller.controller.orbit
    for values, words in (
        ({"range": 125.0}, "the nearest orbit that can be flown has a range of"),
        ({"airspeed": 31.9, "range": 140.0, "altitude": 110.0}, "nearest orbit"),
        ({"target_noise": 0.5, "range": 310.0, "airspeed": 40.0}, "airspeed"),
        ({"target_noise": 0.5, "horizon": 30}, "'horizon' is 30"),
        ({"range": 310.0, "altitude": float("nan")}, "altitude"),
        ({"range": 310.0, "no_such_parameter": 1.0}, "undeclared"),
    ):
        answer = flight.set(**values)
        assert not answer.successful, values
        assert words in answer.reason, answer.reason
        assert flight.controller.parameters == before
        assert flight.controller.controller.orbit == orbit
        for name in values:
            if hasattr(before, name):
                assert flight.controller.get_parameter(name).value == getattr(before, name)
    assert flight.commanded()
    assert flight.told()[1]["mode"] == "optimal plan"


def test_the_paper_takes_a_new_orbit():
    flight = Flight("paper")
    try:
        flight.add_all()
        assert flight.commanded()
        before = flight.told()[1]["terminal set"]
        assert flight.set(range=350.0, direction="counter_clockwise").successful  # as in the README
        assert flight.commanded(20)
        assert flight.told()[1]["mode"] == "optimal plan"
        assert flight.told()[1]["direction"] == "counter_clockwise"
        assert before == "neither: no terminal set is flown"
        assert flight.spin(lambda: flight.told()[1]["terminal set"] == before)
        answer = flight.set(range=51.0, altitude=50.0, airspeed=19.0)
        assert not answer.successful
        assert "must exceed" in answer.reason
        answer = flight.set(state_weights=[1.0] * 5)
        assert not answer.successful
        assert "in flight unless terminal_constraint is 'artificial_orbit'" in answer.reason
        assert flight.commanded()
    finally:
        flight.end()


def test_a_lower_control_rate_is_no_rate_that_is_not_kept(flight):
    flight.add_all(speed=None)
    assert flight.commanded()
    assert flight.set(control_rate=5.0).successful
    flight.spin(lambda: False, 1.0)
    before = flight.controller.report.deadlines_missed
    assert flight.commanded(10)
    assert flight.controller.report.deadlines_missed == before


def test_lag_dead_time_and_budget_change_in_flight(flight):
    flight.add_all()
    assert flight.commanded()
    wanted = {"rate_lag": [0.3, 0.3, 0.2], "dead_time": [0.1, 0.2, 0.2], "solve_time_max": 0.9}
    assert flight.set(**wanted).successful
    assert flight.commanded(20)
    assert flight.told()[1]["mode"] == "optimal plan"
    assert flight.controller.controller.formulation.solver.time_limit == 0.9
    assert flight.controller.parameters.rate_lag == (0.3, 0.3, 0.2)


def test_small_margins_are_told_at_configuration_and_after_a_change(flight):
    controller = flight.add(NmpcController, "controller", gain_margin_min=60.0)

    def told():
        controller._margins.wait()
        return [words for _, words in controller.controller.events.take()]

    assert any("gain_margin_min is 60 dB" in words for words in told())
    assert flight.set(gain_margin_min=6.0).successful
    assert not any("margin" in words for words in told())
    assert flight.set(input_weights=[0.04] * 3, rate_weights=[0.0] * 3).successful
    assert any("turn bears 0." in words for words in told())


@pytest.fixture
def steered():
    steered = Flight("small_uav", "target_publisher.speed=4.0")
    steered.truths = []
    steered.asker.create_subscription(
        TARGET_TRUTH.type, TARGET_TRUTH.name, steered.truths.append, 1000
    )
    steered.add_all()
    assert steered.commanded()
    yield steered
    steered.end()


def place(state):
    position = state.pose.pose.position
    return np.array([position.x, position.y, position.z])


def test_commands_come_only_while_engaged(steered):
    answer = steered.ask(SetBool, "engage", data=False)
    assert answer.success
    assert "flies its plan to the end, then holds" in answer.message
    before = len(steered.commands)
    told = "disengaged by the service engage: no command is sent"
    assert steered.spin(lambda: steered.told()[0] == told)
    simulator = steered.told
    assert steered.spin(lambda: "no plan left" in simulator("uav_simulator")[0])
    assert len(steered.commands) <= before + 1  # one may have been under way
    # What has been stopped is not started by the lifecycle.
    assert steered.change(Transition.TRANSITION_DEACTIVATE)
    refused = steered.ask(SetBool, "engage", data=True)
    assert (refused.success, "not active" in refused.message) == (False, True)
    assert steered.change(Transition.TRANSITION_ACTIVATE)
    steered.fly(1.0)
    assert len(steered.commands) <= before + 1
    assert steered.ask(SetBool, "engage", data=True).success
    assert steered.commanded()
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    assert steered.told()[1]["messages refused"] == "0"


def test_a_pause_is_survived_without_a_fallback(steered):
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    changes = steered.told()[1]["mode changes"]
    answer = steered.ask(SetBool, "pause", "uav_simulator", data=True)
    assert answer.success, answer.message
    steered.spin(lambda: False, 0.3)
    states, commands = len(steered.states), len(steered.commands)
    steered.spin(lambda: False, 4.0 * steered.configuration.controller.state_timeout)
    assert (len(steered.states), len(steered.commands)) == (states, commands)
    assert steered.told("uav_simulator")[0] == "paused: time stands still"
    assert steered.told()[0] == "simulated time stands still"
    assert steered.ask(SetBool, "pause", "uav_simulator", data=False).success
    assert steered.commanded(20)
    assert steered.told()[1]["mode changes"] == changes
    assert steered.told()[1]["mode"] == "optimal plan"


def test_the_walls_time_cannot_be_paused_nor_sped_up():
    steered = Flight()
    try:
        steered.add_all(speed=None)
        answer = steered.ask(SetBool, "pause", "uav_simulator", data=True)
        assert not answer.success
        assert "the wall's" in answer.message
        refused = steered.set("uav_simulator", speed=2.0)
        assert not refused.successful
        assert "must stay 1.0 without publish_clock" in refused.reason
        assert steered.commanded()
    finally:
        steered.end()


def test_after_a_reset_the_flight_begins_anew(steered):
    start = np.array(steered.configuration.simulator.initial_position)
    assert steered.spin(lambda: np.linalg.norm(place(steered.states[-1]) - start) > 150.0)
    stamp = steered.states[-1].header.stamp.sec
    answer = steered.ask(Trigger, "reset", "uav_simulator")
    assert answer.success, answer.message
    steered.states.clear()
    assert steered.spin(lambda: steered.states)
    assert np.linalg.norm(place(steered.states[0]) - start) < 10.0
    assert steered.states[0].header.stamp.sec >= stamp  # the clock goes on
    assert steered.commanded(20)
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    assert steered.spin(lambda: steered.told("uav_simulator")[0] == "flying on commands")


def test_wind_noise_and_speed_change_in_flight(steered):
    assert steered.set("uav_simulator", wind=[5.0, -1.0, 0.0], position_noise=0.5).successful
    assert steered.spin(lambda: steered.told("uav_simulator")[1]["wind east [m/s]"] == "5")
    assert steered.spin(lambda: float(steered.told()[1]["drift east [m/s]"]) > 3.0)
    assert steered.set("uav_simulator", speed=0.1).successful
    first = steered.simulator._now
    steered.spin(lambda: False, 3.0)
    assert 0 < steered.simulator._now - first <= 4e8  # 0.3 s; before it was 15 s
    for values, words in (
        ({"seed": 3}, "read-only"),
        ({"wind": [200.0, 0.0, 0.0]}, "'wind' is [200.0, 0.0, 0.0], must be"),
        ({"gust_intensity": -1.0, "wind": [1.0, 0.0, 0.0]}, "gust_intensity"),
        ({"hold_climb_max": 4.0}, "the plant 'vehicle' cannot change it in flight"),
    ):
        refused = steered.set("uav_simulator", **values)
        assert not refused.successful
        assert words in refused.reason, refused.reason
    assert steered.simulator.parameters.wind == (5.0, -1.0, 0.0)


def test_the_target_goes_where_it_is_sent_and_says_so(steered):
    publisher = steered.asker.create_publisher(TARGET_GOAL.type, TARGET_GOAL.name, 1)
    assert steered.spin(lambda: publisher.get_subscription_count() > 0)

    def send(goal, frame="map"):
        message = TARGET_GOAL.type()
        set_point(message, 0, np.array(goal))
        message.header.frame_id = frame
        publisher.publish(message)

    refused = lambda: int(steered.told("target_publisher")[1]["goals refused"])  # noqa: E731
    assert steered.spin(lambda: steered.says("target_publisher"))
    for goal, frame in ((20.0, "odom"), (np.nan, "map"), (2e6, "map")):
        before = refused()
        send([goal, 0.0, 0.0], frame)
        assert steered.spin(lambda before=before: refused() > before)
    send([12.0, 0.0, 3.0])
    assert steered.spin(lambda: "drives to (12, 0, 3)" in steered.told("target_publisher")[0])
    goal = np.array([12.0, 0.0, 3.0])
    there = lambda: truth_from_odometry(steered.truths[-1])[1]  # noqa: E731
    assert steered.spin(lambda: np.array_equal(there(), goal))
    assert steered.target.parameters.motion == "stationary"
    assert steered.set("target_publisher", motion="circle", radius=40.0).successful
    assert steered.spin(lambda: not np.array_equal(there(), goal))
    unknown = steered.set("target_publisher", motion="waltz")
    assert not unknown.successful
    assert "circle" in unknown.reason and "zigzag" in unknown.reason
    assert steered.target.parameters.motion == "circle"
    told = [truth_from_odometry(message) for message in steered.truths]
    steps = np.diff([stamp for stamp, _, _ in told]) * 1e-9
    moved = np.linalg.norm(np.diff([position for _, position, _ in told], axis=0), axis=1)
    assert np.all(moved <= 4.0 * steps + 1e-6)  # it never jumps


def test_what_is_set_to_what_it_is_changes_nothing(steered, monkeypatch):
    """All parameters, as a tool that restores a file sends them."""
    parameters, controller = (steered.configuration.controller, steered.controller.controller)
    taken, take = [], controller.change

    def change(**values):
        taken.append(values)
        take(**values)

    monkeypatch.setattr(controller, "change", change)
    values = {
        field.name: list(value) if isinstance(value, tuple) else value
        for field in dataclasses.fields(parameters)
        for value in (getattr(parameters, field.name),)
    }
    assert steered.set(**values).successful
    assert taken == []
    assert steered.set(**{**values, "range": 310.0}).successful
    assert len(taken) == 1
    assert controller.parameters.range == 310.0
    assert not steered.set(**{**values, "range": 1.0}).successful
    assert controller.parameters.range == 310.0
    assert steered.set(**values).successful
    assert controller.parameters == parameters
