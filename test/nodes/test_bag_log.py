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

"""What a bag tells of a flight: series, the target's motion, and the last complaint."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from filled_messages import SECOND, filled_command, filled_odometry, filled_status, write_messages

from uav_tracking_mpc.nodes.bag_log import (
    beside_commands,
    last_complaint,
    latency,
    not_recorded,
    sighted_target,
    simulated_target,
)
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY
from uav_tracking_mpc.settings.configuration import load_configuration

BEGAN = 1_700_000_000_000_000_000


def test_a_simulated_target_moves_from_when_it_began():
    overrides = ["target_publisher.motion=line", "target_publisher.speed=2.0"]
    target = load_configuration("small_uav", overrides).target
    flown = simulated_target(target, BEGAN, [BEGAN, BEGAN + 3 * SECOND])
    np.testing.assert_allclose(flown.position[:, 0], [0.0, 6.0])
    np.testing.assert_allclose(flown.velocity, [[2.0, 0.0, 0.0]] * 2)
    assert simulated_target(target, BEGAN, []).position.shape == (0, 3)


def test_a_sighted_target_is_interpolated():
    sightings = [(BEGAN + k * SECOND, np.array([3.0 * k, -k, 1.0])) for k in (0, 2, 1, 3)]
    flown = sighted_target(sightings, [BEGAN + SECOND // 2, BEGAN + 2 * SECOND])
    np.testing.assert_allclose(flown.position, [[1.5, -0.5, 1.0], [6.0, -2.0, 1.0]])
    np.testing.assert_allclose(flown.velocity, [[3.0, -1.0, 0.0]] * 2)


def test_a_target_that_was_seen_once_stands():
    flown = sighted_target([(BEGAN, np.ones(3))], [BEGAN + SECOND])
    np.testing.assert_allclose(flown.position, [[1.0, 1.0, 1.0]])
    np.testing.assert_allclose(flown.velocity, [[0.0, 0.0, 0.0]])


def test_a_target_that_was_never_seen_is_an_error():
    with pytest.raises(ValueError, match="no position of the target"):
        sighted_target([], [BEGAN])


def test_a_target_that_tells_the_truth_is_believed():
    """Steered, its parameters at the start say nothing of where it was: a circle, told at 20 Hz."""
    target = load_configuration("small_uav").target
    stamps = [BEGAN + k * SECOND // 20 for k in range(200)]

    def motion(stamp):
        angle = 0.05 * (stamp - BEGAN) / SECOND
        around = np.array([np.cos(angle), np.sin(angle), 0.0])
        return 100.0 * around, 5.0 * np.array([-around[1], around[0], 0.0])

    truths = [(stamp, *motion(stamp)) for stamp in reversed(stamps)]
    asked = [BEGAN, BEGAN + SECOND // 3, BEGAN + 7 * SECOND + 12_345_678]
    flown = simulated_target(target, BEGAN, asked, truths)
    np.testing.assert_allclose(flown.position, [motion(stamp)[0] for stamp in asked], atol=1e-6)
    np.testing.assert_allclose(flown.velocity, [motion(stamp)[1] for stamp in asked], atol=1e-4)


def test_beyond_what_was_told_it_moves_straight_on():
    target, told = load_configuration("small_uav").target, (np.ones(3), np.array([2.0, 0.0, 0.0]))
    for truths in (
        [(BEGAN, *told)],
        [(BEGAN, *told), (BEGAN + SECOND, told[0] + told[1], told[1])],
    ):
        flown = simulated_target(target, 0, [BEGAN - SECOND, BEGAN + 2 * SECOND], truths)
        np.testing.assert_allclose(flown.position[:, 0], [-1.0, 5.0])


def test_latency_is_from_a_state_to_the_command_that_answers_it():
    states = [(1, 1_000), (2, 2_000), (3, 3_000)]
    found = latency(states, [(1, 2_000), (3, 7_000), (9, 8_000)])
    assert (found.median, found.max) == (2.5, 4.0)
    assert latency(states, [(9, 8_000)]) is None


def test_a_value_belongs_to_the_command_before_it():
    np.testing.assert_array_equal(
        beside_commands([10, 20, 30], [(5, 1.0), (11, 2.0), (35, 3.0)]), [2.0, np.nan, 3.0]
    )


OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def complaint(path, *said):
    """Of a bag with a state a second for 10 s, a command at 1 s, and what nodes said when."""
    states = [
        (ODOMETRY, second * SECOND, filled_odometry(second * SECOND, [9.0] * 6))
        for second in range(11)
    ]
    command = COMMAND, SECOND, filled_command(SECOND, np.zeros((2, 3)))
    statuses = []
    for when, node, level, words, *reason in said:
        values = dict(zip(["mode reason"], reason, strict=False))
        status = filled_status(when * SECOND, node, words, level, values)
        statuses.append((DIAGNOSTICS, when * SECOND + 1, status))
    bag = write_messages(path, sorted([*states, command, *statuses], key=lambda each: each[1]))
    return last_complaint(bag)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ([], ""),
        ([(2, "pilot", OK, "fine")], ""),
        (
            [(2, "red/pilot", ERROR, "two of them"), (3, "red/pilot", OK, "fine")],
            "red/pilot said at 1.0 s: two of them",
        ),
        (
            [(2, "pilot", ERROR, "loiter", "target lost"), (5, "vehicle", WARN, "holding")],
            "pilot said at 1.0 s: loiter (target lost)",
        ),
        ([(2, "pilot", WARN, "slow"), (3, "pilot", OK, "fine")], ""),
        (
            [(2, "pilot", WARN, "slow"), (3, "pilot", DiagnosticStatus.STALE, "ended")],
            "pilot said at 1.0 s: slow",
        ),
        ([(2, "pilot", WARN, "slow"), (3, "other", OK, "fine")], "pilot said at 1.0 s: slow"),
        ([(12, "pilot", ERROR, "after the last state, as the nodes end")], ""),
    ],
)
def test_the_last_error_counts_else_a_warning_that_stands(tmp_path, said, words):
    assert complaint(tmp_path / "flight.mcap", *said) == words


@pytest.mark.parametrize(
    ("sent", "words"), [(10, ""), (11, ""), (40, "10 of 40 commands were recorded"), (None, "")]
)
def test_a_record_that_begins_after_the_flight_says_so(tmp_path, sent, words):
    commands = [
        (COMMAND, second * SECOND, filled_command(second * SECOND, np.zeros((2, 3))))
        for second in range(10)
    ]
    values = {} if sent is None else {"commands sent": sent}
    status = filled_status(9 * SECOND, "nmpc_controller", "tracking", OK, values)
    bag = tmp_path / "flight.mcap"
    write_messages(bag, [*commands, (DIAGNOSTICS, 9 * SECOND + 1, status)])
    found = not_recorded(bag)
    assert found.startswith(words)
    assert bool(found) is bool(words)
