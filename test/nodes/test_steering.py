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

from dataclasses import asdict
from itertools import pairwise

import numpy as np
import pytest
from filled_messages import filled_point
from node_flight import Flight
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, truth_from_odometry
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros.diagnostics import OK, WARN
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH

pytestmark = pytest.mark.nodes


def test_another_orbit_is_flown_without_a_jump(flying):
    assert flying.commanded(30)
    assert flying.spin(lambda: flying.told()[1].get("mode") == "optimal plan")
    begin = len(flying.commands)
    assert flying.set(range=340.0, altitude=140.0) == ""
    assert flying.controller.parameters.orbit.range == 340.0
    assert flying.commanded(60)
    heard = flying.commands[begin - 1 :]
    times = [1e-9 * nanoseconds(message.header.stamp) for message in heard]
    periods = np.diff(times) * flying.controller.parameters.control_rate  # more under load
    steps = np.abs(np.diff(flying.inputs()[begin - 1 :], axis=0)) / periods[:, np.newaxis]
    # Full bank the other way is what the new orbit asks for: half a second is spent on it.
    turn = 0.5 * flying.controller.parameters.envelope.turn_rate_max(22.0)
    assert np.all(np.max(steps, axis=0) < [turn, 0.25, 2.5])
    assert flying.told()[1]["mode"] == "optimal plan"
    wanted = {"rate_lag": [0.3, 0.3, 0.2], "dead_time": [0.1, 0.2, 0.2], "solve_time_max": 0.9}
    assert flying.set(**wanted) == ""
    assert flying.controller.controller.formulation.solver.time_limit == 0.9
    assert flying.controller.parameters.rate_lag == (0.3, 0.3, 0.2)
    # It climbs and widens.
    assert flying.spin(lambda: flying.states[-1].pose.pose.position.z > 125.0)
    assert flying.told()[1]["mode"] == "optimal plan"


def test_what_is_refused_leaves_everything_as_it_was(flying):
    before, orbit = flying.controller.parameters, flying.controller.controller.orbit
    for values, words in (
        ({"range": 125.0}, "the nearest orbit that can be flown has a range of"),
        ({"airspeed": 31.9, "range": 140.0, "altitude": 110.0}, "nearest orbit"),
        ({"target_noise": 0.5, "range": 310.0, "airspeed": 40.0}, "airspeed"),
        ({"target_noise": 0.5, "horizon": 30}, "'horizon' is 30"),
        ({"range": 310.0, "altitude": float("nan")}, "altitude"),
        ({"range": 310.0, "no_such_parameter": 1.0}, "undeclared"),
    ):
        assert words in flying.set(**values)
        assert flying.controller.parameters == before
        assert flying.controller.controller.orbit == orbit
        for name in values.keys() & asdict(before).keys():
            assert flying.controller.get_parameter(name).value == getattr(before, name)
    assert flying.commanded()
    assert flying.told()[1]["mode"] == "optimal plan"


@pytest.fixture
def paper():
    paper = Flight("paper")
    yield paper
    paper.end()


def test_the_paper_takes_a_new_orbit(paper):
    paper.add_all()
    assert paper.commanded()
    before = paper.told()[1]["terminal set"]
    assert paper.set(range=350.0, direction="counter_clockwise") == ""  # as in the README
    assert paper.commanded(20)
    assert paper.told()[1]["mode"] == "optimal plan"
    assert paper.told()[1]["direction"] == "counter_clockwise"
    assert before == "neither: no terminal set is flown"
    assert paper.spin(lambda: paper.told()[1]["terminal set"] == before)
    assert "must exceed" in paper.set(range=51.0, altitude=50.0, airspeed=19.0)
    refusal = paper.set(state_weights=[1.0] * 5)
    assert "in flight unless terminal_constraint is 'artificial_orbit'" in refusal
    assert paper.commanded()


def test_a_lower_control_rate_is_no_rate_that_is_not_kept(flight):
    flight.add_all(speed=None)
    assert flight.commanded()
    assert flight.set(control_rate=5.0) == ""
    assert flight.commanded(2)
    before = flight.controller.report.deadlines_missed
    assert flight.commanded(6)
    assert flight.controller.report.deadlines_missed == before


def test_small_margins_are_told_at_configuration_and_after_a_change(flight):
    parameters = {**asdict(flight.configuration.controller), "gain_margin_min": 60.0}
    controller = flight.add(NmpcController, **parameters)

    def told():
        controller._margins.wait()
        return str([words for _, words in controller.controller.events.take()])

    assert "gain_margin_min is 60 dB" in told()
    assert flight.set(gain_margin_min=6.0) == ""
    assert "margin" not in told()
    assert flight.set(input_weights=[0.04] * 3, rate_weights=[0.0] * 3) == ""
    assert "turn bears 0." in told()


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
    values = steered.told()[1]  # nothing is estimated meanwhile: a number would be read as the air
    assert {values["drift east [m/s]"], values["drift up [m/s]"]} == {"unknown"}
    assert steered.tells("no plan left", "uav_simulator")
    assert len(steered.commands) <= before + 1  # one may have been under way
    # What has been stopped is not started by the lifecycle.
    assert steered.change("deactivate")
    refused = steered.ask(SetBool, "engage", data=True)
    assert (refused.success, "not active" in refused.message) == (False, True)
    assert steered.change("activate")
    steered.fly(1.0)
    assert len(steered.commands) <= before + 1
    assert steered.ask(SetBool, "engage", data=True).success
    assert steered.commanded()
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    assert steered.told()[1]["messages refused"] == "0"


def test_a_pause_is_survived_without_a_fallback(steered):
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    changes = steered.told()[1]["mode changes"]
    # Whatever it says then: nothing more is said while time stands.
    steered.simulator._diagnostics.status.begin(OK, "fine")
    steered.simulator._diagnostics.report(WARN, "commands are late")
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


def test_who_is_disengaged_while_time_stands_has_lost_no_state(steered):
    assert steered.spin(lambda: steered.told()[1]["mode"] == "optimal plan")
    assert steered.ask(SetBool, "pause", "uav_simulator", data=True).success
    for engaged in (False, True):
        assert steered.ask(SetBool, "engage", data=engaged).success
        steered.spin(lambda: False, 4.0 * steered.configuration.controller.state_timeout)
        assert "lost" not in steered.told()[0]
    assert steered.ask(SetBool, "pause", "uav_simulator", data=False).success
    assert steered.commanded(20)


def test_the_walls_time_cannot_be_paused_nor_sped_up(flight):
    flight.add_all(speed=None)
    answer = flight.ask(SetBool, "pause", "uav_simulator", data=True)
    assert not answer.success
    assert "the wall's" in answer.message
    refusal = flight.set("uav_simulator", speed=2.0)
    assert "must stay 1.0 without publish_clock" in refusal
    assert flight.commanded()


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
    assert steered.set("uav_simulator", wind=[5.0, -1.0, 0.0], position_noise=0.5) == ""
    assert steered.spin(lambda: steered.told("uav_simulator")[1]["wind east [m/s]"] == "5")
    assert steered.spin(lambda: float(steered.told()[1]["drift east [m/s]"]) > 3.0)
    assert steered.set("uav_simulator", speed=0.1) == ""
    first = steered.simulator._now
    steered.spin(lambda: False, 1.0)
    assert 0 < steered.simulator._now - first <= 2e8  # 0.1 s; before it was 5 s
    for values, words in (
        ({"seed": 3}, "read-only"),
        ({"wind": [200.0, 0.0, 0.0]}, "'wind' is [200.0, 0.0, 0.0], must be"),
        ({"gust_intensity": -1.0, "wind": [1.0, 0.0, 0.0]}, "gust_intensity"),
        ({"hold_climb_max": 4.0}, "the plant 'vehicle' cannot change it in flight"),
    ):
        assert words in steered.set("uav_simulator", **values)
    assert steered.simulator.parameters.wind == (5.0, -1.0, 0.0)


def test_the_target_goes_where_it_is_sent_and_says_so(steered):
    publisher = steered.asker.create_publisher(TARGET_GOAL.type, TARGET_GOAL.name, 1)
    assert steered.spin(lambda: publisher.get_subscription_count() > 0)

    def refused():
        return int(steered.told("target_publisher")[1]["goals refused"])

    def there():
        return truth_from_odometry(steered.truths[-1])[1]

    assert steered.spin(lambda: steered.says("target_publisher"))
    for east, frame in ((20.0, "odom"), (np.nan, "map"), (2e6, "map")):
        before, goal = refused(), filled_point(0, [east, 0.0, 0.0])
        goal.header.frame_id = frame
        publisher.publish(goal)
        assert steered.spin(lambda before=before: refused() > before)
    goal = np.array([12.0, 0.0, 3.0])
    publisher.publish(filled_point(0, goal))
    assert steered.tells("drives to (12, 0, 3)", "target_publisher")
    assert steered.spin(lambda: np.array_equal(there(), goal))
    assert steered.target.parameters.motion == "stationary"
    assert steered.set("target_publisher", motion="circle", radius=40.0) == ""
    assert steered.spin(lambda: not np.array_equal(there(), goal))
    refusal = steered.set("target_publisher", motion="waltz")
    assert "circle" in refusal and "zigzag" in refusal
    assert steered.target.parameters.motion == "circle"
    for (begin, place, _), (end, next_place, _) in pairwise(
        map(truth_from_odometry, steered.truths)
    ):  # it never jumps
        assert np.linalg.norm(next_place - place) <= 4e-9 * (end - begin) + 1e-6


def test_what_is_set_to_what_it_is_changes_nothing(steered, monkeypatch):
    """All parameters, as a tool that restores a file sends them."""
    parameters, controller = steered.configuration.controller, steered.controller.controller
    taken, take = [], controller.change

    def change(**values):
        taken.append(values)
        take(**values)

    monkeypatch.setattr(controller, "change", change)
    values = {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in asdict(parameters).items()
    }
    assert steered.set(**values) == ""
    assert taken == []
    assert steered.set(**{**values, "range": 310.0}) == ""
    assert len(taken) == 1
    assert controller.parameters.range == 310.0
    assert steered.set(**{**values, "range": 1.0})
    assert controller.parameters.range == 310.0
    assert steered.set(**values) == ""
    assert controller.parameters == parameters
