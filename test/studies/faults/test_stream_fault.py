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

"""What holds for every fault that strikes messages."""

import numpy as np
import pytest

pytest.importorskip("rclpy")

from fault_streams import FIRST, STREAM_FAULTS, arrivals, healthy

from uav_tracking_mpc.nodes.conversions import (
    plan_from_command,
    position_from_point,
    vehicle_from_odometry,
)
from uav_tracking_mpc.nodes.message_checks import MessageError
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.stream_fault import FAMILIES, MessageFault

READERS = {
    ODOMETRY.name: vehicle_from_odometry,
    TARGET.name: position_from_point,
    COMMAND.name: plan_from_command,
}
STRUCK = [(label, topic) for label, fault in STREAM_FAULTS.items() for topic in fault.streams]


@pytest.mark.parametrize(("label", "topic"), STRUCK, ids=lambda case: getattr(case, "name", case))
def test_a_fault_changes_its_streams_and_a_seed_is_a_fault(label, topic):
    sent = [(0.0, healthy(topic, second)) for second in range(FIRST, FIRST + 100)]
    # As text: nan is not itself.
    assert repr(arrivals(label, topic, 100)) != repr(sent)
    assert repr(arrivals(label, topic, 100)) == repr(arrivals(label, topic, 100))


@pytest.mark.parametrize(
    "label", [label for label, fault in STREAM_FAULTS.items() if isinstance(fault, MessageFault)]
)
def test_good_messages_come_among_changed_ones(label):
    (topic,) = STREAM_FAULTS[label].streams
    changed = [
        repr(message) != repr(healthy(topic, second))
        for second, (_, message) in enumerate(arrivals(label, topic), FIRST)
    ]
    assert 0.3 < np.mean(changed) < 0.7


@pytest.mark.parametrize("word", ["nan", "inf", "frame"])
@pytest.mark.parametrize("topic", [ODOMETRY, TARGET, COMMAND], ids=lambda topic: topic.name)
def test_what_nobody_may_fly_on_is_refused(topic, word):
    heard = arrivals(f"{FAMILIES[topic.name]}_{word}", topic)
    changed = [
        message
        for second, (_, message) in enumerate(heard, FIRST)
        if repr(message) != repr(healthy(topic, second))
    ]
    assert changed
    for message in changed:
        with pytest.raises(MessageError):
            READERS[topic.name](message)


def test_variants_are_named_after_their_topics():
    assert STREAM_FAULTS["air_velocity_frame"].streams == (AIR_VELOCITY,)
    assert STREAM_FAULTS["air_velocity_frame"].family == "air_velocity"
