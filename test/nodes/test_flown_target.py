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

"""Where the target of a recorded flight was."""

import numpy as np
import pytest

from uav_tracking_mpc.nodes.flown_target import sighted_target, simulated_target
from uav_tracking_mpc.settings.configuration import load_configuration

BEGAN = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


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
