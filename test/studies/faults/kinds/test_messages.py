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

import math

import numpy as np
import pytest
from node_harness import vehicle_from_odometry

pytest.importorskip("rclpy")

from fault_streams import FIRST, REACH, STREAM_FAULTS, arrivals, healthy

from uav_tracking_mpc.nodes.messages.conversions import plan_from_command, position_from_point
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ODOMETRY,
    TARGET,
    MessageError,
)


@pytest.mark.parametrize(
    ("label", "share", "latest"),
    [
        ("loss", pytest.approx(0.8, abs=0.1), 0.0),
        ("jitter", 1.0, 0.2),
        ("odometry_reordered", 1.0, 0.3),
        ("odometry_duplicated", 3.0, 0.3),
    ],
)
def test_so_much_arrives_so_late(label, share, latest):
    heard = arrivals(label, ODOMETRY, 400)
    delays = np.array([delay for delay, _ in heard])
    assert len(heard) / 400 == share
    assert delays.min() < 0.02
    assert delays.max() == pytest.approx(latest, abs=0.02)
    if label == "odometry_reordered":
        assert set(delays) == {0.0, 0.3}  # on time, or behind later ones
    if label == "odometry_duplicated":
        assert {message.header.stamp.sec for _, message in heard[:3]} == {100}


@pytest.mark.parametrize(
    ("label", "topics"),
    [
        ("gap_state", (ODOMETRY, AIR_VELOCITY)),
        ("gap_target", (TARGET,)),
        ("gap_command", (COMMAND,)),
        ("target_lost", (TARGET,)),
        ("clock_pause", (CLOCK,)),
    ],
)
def test_silence_leaves_nothing(label, topics):
    assert STREAM_FAULTS[label].streams == topics
    for topic in topics:
        assert arrivals(label, topic) == []


@pytest.mark.parametrize(
    ("label", "topic", "read"),
    [
        ("odometry_absurd", ODOMETRY, vehicle_from_odometry),
        ("target_absurd", TARGET, position_from_point),
    ],
)
def test_absurd_places_pass_every_check_of_a_single_message(label, topic, read):
    values = np.array([read(message) for _, message in arrivals(label, topic)])
    assert np.isfinite(values).all() and np.abs(values).max() > 1e6


def test_a_target_leaps_to_one_place_and_stays_there():
    leapt = [message.point for _, message in arrivals("target_teleport", TARGET)]
    ((x, y),) = {(point.x, point.y) for point in leapt}
    assert math.hypot(x - 1.0, y - 2.0) == pytest.approx(REACH)


def test_commands_lose_all_points_or_the_velocities_of_all_and_are_refused():
    points = len(healthy(COMMAND).points)
    seen = set()
    for _, message in arrivals("command_empty", COMMAND, 50):
        seen.add((len(message.points), sum(len(point.velocities) for point in message.points)))
        if not all(point.velocities for point in message.points) or not message.points:
            with pytest.raises(MessageError):
                plan_from_command(message)
    assert seen == {(points, points), (points, 0), (0, 0)}


@pytest.mark.parametrize(("label", "sign"), [("clock_forward", 1), ("clock_backward", -1)])
def test_the_clock_jumps_by_one_offset_and_never_below_zero(label, sign):
    offsets = set()
    for seed in range(20):
        seconds = [message.clock.sec for _, message in arrivals(label, CLOCK, seed=seed)]
        assert min(seconds) >= 0
        if min(seconds) > 0:
            ((offset),) = {second - true for true, second in enumerate(seconds, FIRST)}
            offsets.add(offset)
    assert offsets
    assert all(sign * offset > 0 for offset in offsets)
