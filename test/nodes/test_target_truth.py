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

"""Truth and goals of a target as messages."""

import numpy as np
import pytest

from uav_tracking_mpc.nodes.conversions import MessageError, set_point
from uav_tracking_mpc.nodes.target_odometry import target_from_odometry
from uav_tracking_mpc.nodes.target_truth import goal_from_point, set_truth, truth_from_odometry
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH

POSITION, VELOCITY = np.array([1.0, -2.0, 3.5]), np.array([0.5, 4.0, -0.25])


def test_the_truth_there_and_back():
    message = TARGET_TRUTH.type()
    set_truth(message, 1_700_000_000_123_456_789, POSITION, VELOCITY)
    stamp, position, velocity = truth_from_odometry(message)
    assert stamp == 1_700_000_000_123_456_789
    np.testing.assert_array_equal([position, velocity], [POSITION, VELOCITY])
    # It is an odometry like that of a tracker.
    np.testing.assert_array_equal(target_from_odometry(message).velocity, VELOCITY)


@pytest.mark.parametrize(
    ("frame", "goal", "words"),
    [
        ("odom", POSITION, "'odom', must be 'map'"),
        ("map", [np.inf, 0.0, 0.0], "point.x is inf, must be finite"),
        ("map", [0.0, np.nan, 0.0], "point.y is nan"),
    ],
)
def test_a_goal_that_is_none_is_refused(frame, goal, words):
    message = TARGET_GOAL.type()
    set_point(message, 0, np.array(goal))
    message.header.frame_id = frame
    with pytest.raises(MessageError, match=words):
        goal_from_point(message)


def test_a_goal_needs_no_stamp():
    message = TARGET_GOAL.type()
    set_point(message, 0, POSITION)
    np.testing.assert_array_equal(goal_from_point(message), POSITION)
