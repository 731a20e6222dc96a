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

"""The transform for /tf is the pose of the odometry."""

import numpy as np
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry

from uav_tracking_mpc.dynamics.frames import rotation_from_course, rotation_from_quaternion
from uav_tracking_mpc.nodes.conversions import nanoseconds, set_odometry
from uav_tracking_mpc.nodes.vehicle_transform import vehicle_transform


def odometry(stamp=5_000_000_007):
    message = Odometry()
    set_odometry(message, stamp, np.array([10.0, -20.0, 30.0, 2.0, 0.3, 15.0]), np.zeros(3))
    return message


def test_it_has_pose_stamp_and_frames_of_the_odometry():
    message = odometry()
    message.header.frame_id, message.child_frame_id = "world", "uav1/base_link"
    transform = vehicle_transform(message)
    assert isinstance(transform, TransformStamped)
    assert transform.header.frame_id == "world"
    assert transform.child_frame_id == "uav1/base_link"
    assert nanoseconds(transform.header.stamp) == 5_000_000_007
    place, q = transform.transform.translation, transform.transform.rotation
    assert (place.x, place.y, place.z) == (10.0, -20.0, 30.0)
    np.testing.assert_allclose(
        rotation_from_quaternion(q.x, q.y, q.z, q.w), rotation_from_course(2.0, 0.3), atol=1e-12
    )


def test_a_message_is_filled_again_in_place():
    transform = vehicle_transform(odometry())
    assert vehicle_transform(odometry(9_000_000_000), transform) is transform
    assert nanoseconds(transform.header.stamp) == 9_000_000_000
