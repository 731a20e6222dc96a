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

"""A flight is steered by services, goals and parameters while it is flown."""

import dataclasses

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from node_flight import Flight
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.nodes.conversions import set_point
from uav_tracking_mpc.nodes.target_truth import truth_from_odometry
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH

pytestmark = pytest.mark.nodes


@pytest.fixture
def flight():
    flight = Flight("small_uav", "target_publisher.speed=4.0")
    flight.truths = []
    flight.asker.create_subscription(
        TARGET_TRUTH.type, TARGET_TRUTH.name, flight.truths.append, 1000
    )
    flight.add_all()
    assert flight.commanded()
    yield flight
    flight.end()


def place(state):
    position = state.pose.pose.position
    return np.array([position.x, position.y, position.z])


def test_commands_come_only_while_engaged(flight):
    answer = flight.ask(SetBool, "engage", data=False)
    assert answer.success
    assert "flies its plan to the end, then holds" in answer.message
    before = len(flight.commands)
    told = "disengaged by the service engage: no command is sent"
    assert flight.spin(lambda: flight.told()[0] == told)
    simulator = flight.told
    assert flight.spin(lambda: "no plan left" in simulator("uav_simulator")[0])
    assert len(flight.commands) <= before + 1  # one may have been under way
    # What has been stopped is not started by the lifecycle.
    assert flight.change(Transition.TRANSITION_DEACTIVATE)
    refused = flight.ask(SetBool, "engage", data=True)
    assert (refused.success, "not active" in refused.message) == (False, True)
    assert flight.change(Transition.TRANSITION_ACTIVATE)
    flight.fly(1.0)
    assert len(flight.commands) <= before + 1
    assert flight.ask(SetBool, "engage", data=True).success
    assert flight.commanded()
    assert flight.spin(lambda: flight.told()[1]["mode"] == "optimal plan")
    assert flight.told()[1]["messages refused"] == "0"


def test_a_pause_is_survived_without_a_fallback(flight):
    assert flight.spin(lambda: flight.told()[1]["mode"] == "optimal plan")
    changes = flight.told()[1]["mode changes"]
    answer = flight.ask(SetBool, "pause", "uav_simulator", data=True)
    assert answer.success, answer.message
    flight.spin(lambda: False, 0.3)
    states, commands = len(flight.states), len(flight.commands)
    flight.spin(lambda: False, 4.0 * flight.configuration.controller.state_timeout)
    assert (len(flight.states), len(flight.commands)) == (states, commands)
    assert flight.told("uav_simulator")[0] == "paused: time stands still"
    assert flight.told()[0] == "simulated time stands still"
    assert flight.ask(SetBool, "pause", "uav_simulator", data=False).success
    assert flight.commanded(20)
    assert flight.told()[1]["mode changes"] == changes
    assert flight.told()[1]["mode"] == "optimal plan"


def test_the_walls_time_cannot_be_paused_nor_sped_up():
    flight = Flight()
    try:
        flight.add_all(speed=None)
        answer = flight.ask(SetBool, "pause", "uav_simulator", data=True)
        assert not answer.success
        assert "the wall's" in answer.message
        refused = flight.set("uav_simulator", speed=2.0)
        assert not refused.successful
        assert "must stay 1.0 without publish_clock" in refused.reason
        assert flight.commanded()
    finally:
        flight.end()


def test_after_a_reset_the_flight_begins_anew(flight):
    start = np.array(flight.configuration.simulator.initial_position)
    assert flight.spin(lambda: np.linalg.norm(place(flight.states[-1]) - start) > 150.0)
    stamp = flight.states[-1].header.stamp.sec
    answer = flight.ask(Trigger, "reset", "uav_simulator")
    assert answer.success, answer.message
    flight.states.clear()
    assert flight.spin(lambda: flight.states)
    assert np.linalg.norm(place(flight.states[0]) - start) < 10.0
    assert flight.states[0].header.stamp.sec >= stamp  # the clock goes on
    assert flight.commanded(20)
    assert flight.spin(lambda: flight.told()[1]["mode"] == "optimal plan")
    assert flight.spin(lambda: flight.told("uav_simulator")[0] == "flying on commands")


def test_wind_noise_and_speed_change_in_flight(flight):
    assert flight.set("uav_simulator", wind=[5.0, -1.0, 0.0], position_noise=0.5).successful
    assert flight.spin(lambda: flight.told("uav_simulator")[1]["wind east [m/s]"] == "5")
    assert flight.spin(lambda: float(flight.told()[1]["drift east [m/s]"]) > 3.0)
    assert flight.set("uav_simulator", speed=0.1).successful
    first = flight.simulator._now
    flight.spin(lambda: False, 3.0)
    assert 0 < flight.simulator._now - first <= 4e8  # 0.3 s; before it was 15 s
    for values, words in (
        ({"seed": 3}, "read-only"),
        ({"wind": [200.0, 0.0, 0.0]}, "'wind' is [200.0, 0.0, 0.0], must be"),
        ({"gust_intensity": -1.0, "wind": [1.0, 0.0, 0.0]}, "gust_intensity"),
        ({"hold_climb_max": 4.0}, "the plant 'vehicle' cannot change it in flight"),
    ):
        refused = flight.set("uav_simulator", **values)
        assert not refused.successful
        assert words in refused.reason, refused.reason
    assert flight.simulator.parameters.wind == (5.0, -1.0, 0.0)


def test_the_target_goes_where_it_is_sent_and_says_so(flight):
    publisher = flight.asker.create_publisher(TARGET_GOAL.type, TARGET_GOAL.name, 1)
    assert flight.spin(lambda: publisher.get_subscription_count() > 0)

    def send(goal, frame="map"):
        message = TARGET_GOAL.type()
        set_point(message, 0, np.array(goal))
        message.header.frame_id = frame
        publisher.publish(message)

    refused = lambda: int(flight.told("target_publisher")[1]["goals refused"])  # noqa: E731
    assert flight.spin(lambda: flight.says("target_publisher"))
    for goal, frame in ((20.0, "odom"), (np.nan, "map"), (2e6, "map")):
        before = refused()
        send([goal, 0.0, 0.0], frame)
        assert flight.spin(lambda before=before: refused() > before)
    send([12.0, 0.0, 3.0])
    assert flight.spin(lambda: "drives to (12, 0, 3)" in flight.told("target_publisher")[0])
    goal = np.array([12.0, 0.0, 3.0])
    there = lambda: truth_from_odometry(flight.truths[-1])[1]  # noqa: E731
    assert flight.spin(lambda: np.array_equal(there(), goal))
    assert flight.target.parameters.motion == "stationary"
    assert flight.set("target_publisher", motion="circle", radius=40.0).successful
    assert flight.spin(lambda: not np.array_equal(there(), goal))
    unknown = flight.set("target_publisher", motion="waltz")
    assert not unknown.successful
    assert "circle" in unknown.reason and "zigzag" in unknown.reason
    assert flight.target.parameters.motion == "circle"
    told = [truth_from_odometry(message) for message in flight.truths]
    steps = np.diff([stamp for stamp, _, _ in told]) * 1e-9
    moved = np.linalg.norm(np.diff([position for _, position, _ in told], axis=0), axis=1)
    assert np.all(moved <= 4.0 * steps + 1e-6)  # it never jumps


def test_what_is_set_to_what_it_is_changes_nothing(flight, monkeypatch):
    """All parameters, as a tool that restores a file sends them."""
    parameters, controller = flight.configuration.controller, flight.controller.controller
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
    assert flight.set(**values).successful
    assert taken == []
    assert flight.set(**{**values, "range": 310.0}).successful
    assert len(taken) == 1
    assert controller.parameters.range == 310.0
    assert not flight.set(**{**values, "range": 1.0}).successful
    assert controller.parameters.range == 310.0
    assert flight.set(**values).successful
    assert controller.parameters == parameters
