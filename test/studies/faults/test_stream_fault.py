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


import pytest
from node_harness import vehicle_from_odometry

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Time
from fault_streams import FIRST, STREAM_FAULTS, arrivals, healthy

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.nodes.messages.conversions import plan_from_command, position_from_point
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET, MessageError
from uav_tracking_mpc.studies.faults.kinds.messages import Corruption
from uav_tracking_mpc.studies.faults.stream_fault import (
    FAMILIES,
    LATEST_STAMP,
    NUMBERS,
    STREAMS,
    shift,
)


def test_stamps_move_as_far_as_stamps_go():
    stamp = Time(sec=100, nanosec=500_000_000)
    shift(stamp, -0.75)
    assert (stamp.sec, stamp.nanosec) == (99, 750_000_000)
    shift(stamp, 1e10)
    assert stamp.sec == LATEST_STAMP


@pytest.mark.parametrize(
    ("topic", "count"), [(ODOMETRY, 7), (TARGET, 3), (AIR_VELOCITY, 3), (COMMAND, 9)]
)
def test_numbers_can_be_set(topic, count):
    message = healthy(topic)
    fields = NUMBERS[topic.name](message)
    assert len(fields) == count
    for value, (holder, name) in enumerate(fields, 1):
        setattr(holder, name, float(value))
    assert [getattr(holder, name) for holder, name in NUMBERS[topic.name](message)] == [
        *range(1, count + 1)
    ]


READERS = {
    ODOMETRY.name: vehicle_from_odometry,
    TARGET.name: position_from_point,
    COMMAND.name: plan_from_command,
}
STRUCK = [(label, topic) for label, fault in STREAM_FAULTS.items() for topic in fault.streams]


@pytest.mark.parametrize(("label", "topic"), STRUCK, ids=lambda case: getattr(case, "name", case))
def test_a_fault_changes_its_streams_and_a_seed_is_a_fault(label, topic):
    sent = [(0.0, healthy(topic, second)) for second in range(FIRST, FIRST + 30)]
    once, again = (repr(arrivals(label, topic, 30)) for _ in range(2))  # as text: nan is not itself
    assert once == again != repr(sent)


def struck(label, topic, count=100):
    """Of messages of which every other one is corrupted those that are."""
    heard = enumerate(arrivals(label, topic, count), FIRST)
    return [message for k, (_, message) in heard if repr(message) != repr(healthy(topic, k))]


@pytest.mark.parametrize(
    "label", [label for label, fault in STREAM_FAULTS.items() if isinstance(fault, Corruption)]
)
def test_good_messages_come_among_changed_ones(label):
    (topic,) = STREAM_FAULTS[label].streams
    assert 30 < len(struck(label, topic)) < 70


@pytest.mark.parametrize("word", ["nan", "inf", "frame"])
@pytest.mark.parametrize("topic", [ODOMETRY, TARGET, COMMAND], ids=lambda topic: topic.name)
def test_what_nobody_may_fly_on_is_refused(topic, word):
    changed = struck(f"{FAMILIES[topic.name]}_{word}", topic, 50)
    assert changed
    for message in changed:
        with pytest.raises(MessageError):
            READERS[topic.name](message)


def test_variants_are_named_after_their_topics():
    assert STREAM_FAULTS["air_velocity_frame"].streams == (AIR_VELOCITY,)
    assert STREAM_FAULTS["air_velocity_frame"].family == "air_velocity"


@pytest.mark.parametrize("topic", STREAMS, ids=lambda topic: topic.name)
def test_one_node_of_a_flight_sends_it(topic):
    assert sum(node in topic.sender for node in NODES) == 1
