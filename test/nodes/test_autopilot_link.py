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

"""The node in the simulator's place, on a plant behind a link."""

import math
import time
from collections import defaultdict
from types import SimpleNamespace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from filled_messages import filled_command, filled_orbit, filled_tracking
from node_harness import tapped
from paced_link import LINK
from processes import refused_start, wait_for
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.nodes import autopilot_link
from uav_tracking_mpc.nodes.autopilot_link import ANSWERS, AutopilotLink
from uav_tracking_mpc.nodes.messages.conversions import measurement_from_odometry, nanoseconds
from uav_tracking_mpc.nodes.ros.diagnostics import ERROR, OK, WARN
from uav_tracking_mpc.nodes.topics import COMMAND, ENGAGED, ODOMETRY, TARGET_ODOMETRY
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.link import LinkParameters

pytestmark = pytest.mark.nodes

ORBIT = FlownOrbit(np.array([0.0, 0.0, 120.0]), np.array([5.0, 0.0, 0.0]), 275.0, 22.0)


@pytest.fixture
def node(nodes):
    """Makes the node with parameters, with what it publishes by topic, and when."""

    def make(**parameters):
        sent = defaultdict(list)
        kind = tapped(AutopilotLink, lambda topic, said: sent[topic].append((time.time_ns(), said)))
        made = nodes.add(kind, **{"link": LINK, **parameters})
        made.sent = sent
        return made

    return make


def command(stamp, plan=((0.05, 0.0, 0.0), (0.04, 0.0, 0.0))):
    return serialize_message(filled_command(stamp, plan, 0.4))


def engage(node, on=True):
    """Ask for it as the service does."""
    answer = node._on_engage(SimpleNamespace(data=on), SimpleNamespace())
    return answer.success, answer.message


def status(node):
    node._look()
    return node._diagnostics.status.level, node._diagnostics.status.message


def flying(node, **parameters):
    """A node whose aircraft is there and told its first states."""
    made = node(**parameters)
    assert wait_for(lambda: made._states > 2)
    return made


@pytest.fixture
def made(node):
    return flying(node)


def test_an_empty_list_is_none_of_bytes(node):
    made = node()
    assert made.get_parameter("origin").type_ is Parameter.Type.NOT_SET
    assert made.parameters.origin == ()


def test_an_empty_list_as_ros_dumps_it_is_empty(node):
    assert node(origin="null").parameters.origin == ()


def test_what_it_is_told_at_the_start_stays_and_is_documented_so(node):
    made = node()
    for each in specifications(LinkParameters):
        assert each.fixed and made.describe_parameter(each.name).read_only, each.name


def test_states_are_published_with_ros_stamps_as_they_come(made):
    heard = made.sent[ODOMETRY.name]
    stamps = [nanoseconds(message.header.stamp) for _, message in heard]
    assert stamps == sorted(stamps)
    for at, message in heard:
        assert 0 <= at - nanoseconds(message.header.stamp) < 5e8
        seen = measurement_from_odometry(message)
        assert abs(seen.position[2] - 100.0) < 5.0
    assert made.sent["uav/air_velocity"][0][1].twist.linear.x == pytest.approx(22.0, abs=0.5)
    assert status(made) == (OK, "paced: not engaged, nothing is commanded")


def test_a_command_reaches_the_link_in_its_time_with_the_orbit_carried_on(made):
    stamp = nanoseconds(made.sent[ODOMETRY.name][-1][1].header.stamp)
    made._on_orbit(filled_orbit(stamp - 100_000_000, ORBIT))
    made._on_command(command(stamp))
    link = made._link
    now = time.time_ns()
    assert link.now() - link.stamps[-1] == pytest.approx((now - stamp) * 1e-9, abs=0.05)
    np.testing.assert_allclose(link.orbits[-1].centre, [0.5, 0.0, 120.0], atol=1e-6)
    made._on_command(command(stamp + 10_000_000_000))
    assert link.orbits[-1] is None  # that orbit is too old
    assert made._values()["commands received"] == 2


def test_what_the_controller_estimates_reaches_the_link_with_the_orbit(made):
    stamp = nanoseconds(made.sent[ODOMETRY.name][-1][1].header.stamp)
    made._on_orbit(filled_orbit(stamp, ORBIT))
    made._on_command(command(stamp))
    assert made._link.orbits[-1].airspeed_now == 0.0  # of a controller that tells none
    made._on_tracking(filled_tracking(stamp, surplus=0.02, airspeed=19.5))
    made._on_command(command(stamp))
    assert (made._link.orbits[-1].airspeed_now, made._link.orbits[-1].surplus) == (19.5, 0.02)
    made._on_tracking(filled_tracking(stamp, airspeed=math.nan))
    made._on_command(command(stamp))
    assert made._link.orbits[-1].airspeed_now == 0.0
    made._on_tracking(filled_tracking(stamp - 3_000_000_000, airspeed=19.5))
    made._on_command(command(stamp))
    assert made._link.orbits[-1].airspeed_now == 0.0  # it is too old
    made._on_tracking(filled_tracking(stamp, airspeed=19.5))
    made._on_tracking(filled_tracking(stamp, airspeed=1e6))
    made._on_tracking(type(filled_tracking(stamp))(name=["airspeed"]))
    assert made._values()["plans refused"] == 2
    made._on_command(command(stamp))
    assert made._link.orbits[-1].airspeed_now == 19.5


def test_what_is_no_command_is_refused_in_words_and_never_reaches_the_link(made):
    for bad in (serialize_message(COMMAND.type()), b"", command(1, plan=[[np.nan, 0.0, 0.0]])):
        made._on_command(bad)
    made._on_orbit(type(filled_orbit(0, ORBIT))())
    assert made._link.stamps == []
    assert made._values()["plans refused"] == 4


def test_it_engages_by_service_and_says_so(made):
    assert engage(made) == (True, ANSWERS[True])
    made._on_command(command(time.time_ns()))
    made._look()
    assert status(made) == (OK, "paced: the commands are flown")
    assert made.sent[ENGAGED.name][-1][1].data is True
    made._link.refusal = "too windy"
    made._on_command(command(time.time_ns()))
    assert status(made) == (ERROR, "paced: the commands are refused")
    assert made._values()["last refusal"] == "too windy"
    assert engage(made, False) == (True, ANSWERS[False])
    made._look()
    assert made.sent[ENGAGED.name][-1][1].data is False


def test_engaging_can_be_refused(node):
    made = flying(node, connection="stubborn")
    assert engage(made) == (False, "the pilot says no")
    success, words = engage(node(connection="nobody"))
    assert not success
    assert "there is no aircraft" in words


def test_asked_to_engage_it_does_so_once_there_is_something_to_fly(node):
    made = flying(node, engage=True)
    now = time.time_ns()
    made._on_command(command(now))  # without an orbit there is nothing to loiter about
    made._look()
    assert not made._link.engaged
    made._on_orbit(filled_orbit(now, ORBIT))
    made._on_command(command(now))
    made._look()
    assert made._link.engaged
    made._link.disengage()  # the pilot took over
    made._look()
    assert not made._link.engaged


def test_it_waits_for_an_aircraft_and_outlives_one_that_fails(node, monkeypatch):
    made = node(connection="nobody")
    assert wait_for(lambda: made._reader.trouble == "nobody answers")
    assert status(made) == (WARN, "paced: no aircraft: nobody answers")
    made._on_command(command(1))  # there is nobody to give it to
    assert made._link.stamps == []
    flown = flying(node)

    def fail(*arguments):
        raise RuntimeError("of a user")

    for name in ("command", "values", "engage"):
        monkeypatch.setattr(flown._link, name, fail)
    flown._on_command(command(time.time_ns()))
    assert "of a user" in flown._refusal
    assert "of a user" in flown._engage()
    assert "of a user" in str(flown._values()["link"])
    monkeypatch.setattr(type(flown._link), "engaged", property(fail))
    flown._look()
    assert flown._diagnostics.status.level == DiagnosticStatus.ERROR
    assert "of a user" in flown._diagnostics.status.message


def test_states_that_stop_are_an_error(made, monkeypatch):
    monkeypatch.setattr(made._link, "measured", lambda timeout: None)
    monkeypatch.setattr(autopilot_link, "SILENCE", 0.05)
    assert wait_for(lambda: made._status(made._state_time + 0.1)[0] == ERROR)
    assert made._status(made._state_time + 0.1)[1] == "paced: connected, but no state comes"


def test_the_first_state_is_waited_for_before_it_is_missed(made, monkeypatch):
    monkeypatch.setattr(made._reader, "_taken", lambda seen: None)
    assert wait_for(lambda: time.monotonic() - made._state_time > 0.2)
    monkeypatch.setattr(made, "_state_time", -math.inf)
    since = made._reader.since
    assert made._status(since + 0.5 * autopilot_link.SILENCE)[0] == OK
    assert made._status(since + 1.5 * autopilot_link.SILENCE)[0] == ERROR


def test_a_target_that_tells_where_it_is_is_published(node):
    made = flying(node, target_system=2)
    ((_, message),) = made.sent[TARGET_ODOMETRY.name]
    assert message.pose.pose.position.y == 2.0
    assert message.twist.twist.linear.x == 4.0
    assert message.header.frame_id == message.child_frame_id == "map"


def test_it_lets_go_at_the_end(made):
    engage(made)
    link = made._link
    made.finish()
    assert not link.engaged
    assert link.closed
    (last,) = made.sent["/diagnostics"][-1][1].status
    assert (last.level, last.message) == (DiagnosticStatus.STALE, "ended")
    assert last.values


def test_an_aircraft_that_cannot_be_flown_ends_the_process_with_one_line():
    arguments = ("-p", f"link:={LINK}", "-p", "connection:=copter")
    assert refused_start("autopilot_link", *arguments) == "it is a copter"


def test_a_link_without_a_clock_of_its_own_is_not_flown():
    words = refused_start("autopilot_link", "-p", "link:=simulated")
    assert "'link' is 'simulated', must be another one" in words
    assert "uav_simulator" in words
