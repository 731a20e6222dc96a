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

"""Stamps of zero: a target's message is of now, a driver's is refused; nothing drops in silence."""

from __future__ import annotations

import time
from types import SimpleNamespace
from unittest import mock

import pytest
from filled_messages import SECOND, filled_air, filled_odometry, filled_point
from node_harness import callback

from uav_tracking_mpc.nodes.messages.conversions import set_stamp
from uav_tracking_mpc.nodes.nmpc_controller import DRAIN, MessageTimes, NmpcController, StallGuard
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.diagnostics import PERIOD, ThrottledWarnings
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    MessageError,
)

STATE = [180.0, 0.0, 40.0, 2.0, 0.0, 4.0]


def clocked(now=1000 * SECOND):
    """A node of which only clock and logger are asked."""
    node = SimpleNamespace(now=now, logger=mock.Mock())
    node.get_clock = lambda: SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=node.now))
    node.get_logger = lambda: node.logger
    return node


def lines(logger):
    """What was logged, in words."""
    return [call.args[0] for call in logger.method_calls]


def stamped(topic, stamp):
    message = topic.type()
    set_stamp(message.header.stamp, stamp)
    return message


def test_times_count_from_the_first_stamp():
    node = clocked()
    times = MessageTimes(node)
    assert times.now() == 0.0
    assert times.measured(ODOMETRY, stamped(ODOMETRY, 999 * SECOND)) == 0.0
    assert times.measured(TARGET, stamped(TARGET, 1001 * SECOND)) == 2.0
    assert times.now() == 1.0


def test_a_target_without_stamp_is_of_now_which_is_said_once_a_topic():
    node = clocked()
    times = MessageTimes(node)
    times.measured(ODOMETRY, stamped(ODOMETRY, 1000 * SECOND))
    for _ in range(3):
        node.now += SECOND // 2
        for topic in (TARGET, TARGET_ODOMETRY):
            assert times.measured(topic, stamped(topic, 0)) == times.now()
    of_position, of_odometry = lines(node.logger)
    assert of_position.startswith("target/position: header.stamp is 0")
    assert of_odometry.startswith("target/odometry: header.stamp is 0")


@pytest.mark.parametrize("topic", [ODOMETRY, AIR_VELOCITY], ids=lambda topic: topic.name)
def test_a_state_without_stamp_is_refused_by_name_and_is_no_origin(topic):
    times = MessageTimes(clocked())
    with pytest.raises(MessageError, match=f"{topic.name}: header.stamp is 0, must be when"):
        times.measured(topic, stamped(topic, 0))
    assert times.measured(topic, stamped(topic, 5 * SECOND)) == 0.0


def test_zero_is_a_time_where_a_simulation_begins():
    times = MessageTimes(clocked(now=SECOND // 2))
    assert times.measured(ODOMETRY, stamped(ODOMETRY, 0)) == 0.0
    assert times.measured(TARGET, stamped(TARGET, 0)) == 0.0


def test_one_subject_does_not_silence_another(monkeypatch):
    node, clock = clocked(), SimpleNamespace(time=100.0)
    monkeypatch.setattr(diagnostics.time, "monotonic", lambda: clock.time)
    warnings = ThrottledWarnings(node)
    for _ in range(3):
        warnings.warn("one", "first")
        warnings.warn("other", "second")
    assert lines(node.logger) == ["first", "second"]
    clock.time += PERIOD
    warnings.warn("one", "again")
    assert node.logger.warning.call_args.args[0] == "again"


@pytest.fixture
def controller(nodes):
    logger = mock.Mock()

    class Logged(NmpcController):
        def get_logger(self):
            return logger if self.controller is not None else super().get_logger()

    return nodes.add(Logged), logger


@pytest.mark.nodes
def test_a_flight_goes_on_points_that_are_published_by_hand(controller):
    """As of `ros2 topic pub target/position ...`, without a stamp."""
    node, logger = controller
    callback(node, ODOMETRY.name)(filled_odometry(time.time_ns(), STATE))
    callback(node, TARGET.name)(filled_point(0))
    callback(node, AIR_VELOCITY.name)(filled_air(time.time_ns(), 10.0))
    callback(node, ODOMETRY.name)(filled_odometry(time.time_ns(), STATE))
    assert node.controller.flying
    assert any("target/position: header.stamp is 0" in words for words in lines(logger))


@pytest.mark.nodes
def test_every_message_that_is_left_out_leaves_a_line(controller):
    node, logger = controller
    begin = time.time_ns()
    callback(node, ODOMETRY.name)(filled_odometry(begin, STATE))
    callback(node, TARGET.name)(filled_point(begin))
    no_newer, no_stamp = "message left out: it is no newer", "header.stamp is 0"
    astray = TARGET_ODOMETRY.type()
    astray.header.frame_id = "odom"
    for topic, message, words in (
        (ODOMETRY, filled_odometry(begin, STATE), f"uav/odometry: {no_newer}"),
        (ODOMETRY, filled_odometry(0, STATE), f"message refused: uav/odometry: {no_stamp}"),
        (AIR_VELOCITY, filled_air(0, 4.0), f"message refused: uav/air_velocity: {no_stamp}"),
        (TARGET, filled_point(begin), f"target/position: {no_newer}"),
        (TARGET_ODOMETRY, astray, "target/odometry: header.frame_id is 'odom', must be 'map'"),
    ):
        hear = callback(node, topic.name)
        logger.reset_mock()
        hear(message)
        assert any(words in each for each in lines(logger)), lines(logger)
        logger.reset_mock()
        hear(message)
        assert lines(logger) == []  # throttled


def test_what_is_heard_first_after_a_stall_is_old():
    guard = StallGuard(0.4)
    assert guard.alive(10.0)
    assert guard.alive(10.39)
    assert not guard.alive(12.0)  # stopped for 1.6 s
    assert not guard.alive(12.0 + 0.9 * DRAIN)
    assert guard.alive(12.0 + 1.1 * DRAIN)


def test_a_first_message_is_no_stall():
    assert StallGuard(0.4).alive(1e6)
