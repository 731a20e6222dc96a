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

"""The recorder begins to listen to the state, for which simulated time waits, as the last."""

import errno
import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from filled_messages import SECOND, circling, filled_command, filled_odometry, filled_point
from rclpy.serialization import serialize_message

from uav_tracking_mpc.nodes.flight_recorder import FLYING, FlightBag, FlightRecorder
from uav_tracking_mpc.nodes.topics import ALL, COMMAND, DIAGNOSTICS, ODOMETRY, TARGET

pytestmark = pytest.mark.nodes


def listens(recorder):
    return any(each.topic_name.endswith(ODOMETRY.name) for each in recorder.subscriptions)


def report(name):
    return DiagnosticArray(status=[DiagnosticStatus(name=f"{name}: status")])


@pytest.mark.parametrize("namespace", ["", "red"])
def test_it_waits_until_each_node_that_flies_knows_of_it(nodes, namespace):
    """A node that sends before it knows who listens is recorded from its second message on."""
    recorder = nodes.add(FlightRecorder, namespace=namespace)
    sender = nodes.peer("sender")
    publishers = {
        topic.name: sender.create_publisher(
            topic.type, topic.name if topic.name[0] == "/" else f"{namespace}/{topic.name}", 10
        )
        for topic in ALL
        if topic is not ODOMETRY
    }
    diagnostics = publishers[DIAGNOSTICS.name]
    assert nodes.spin(lambda: all(each.senders for each in recorder._needed))
    assert nodes.spin(lambda: diagnostics.get_subscription_count())
    tell = diagnostics.publish
    begin = f"{namespace}/".lstrip("/")
    for name in (*(f"{begin}{name}" for name in FLYING[1:]), f"blue/{FLYING[0]}"):
        tell(report(name))
        told = name.encode()
        assert nodes.spin(lambda told=told: told in recorder._latest.get(DIAGNOSTICS.name, b""))
        recorder._release()
        assert not listens(recorder)
    assert nodes.spin(lambda: listens(recorder), also=lambda: tell(report(f"{begin}{FLYING[0]}")))
    assert recorder.heard == 0  # what others publish does not keep a flight from ending


def test_with_a_real_autopilot_it_waits_for_nobody(nodes):
    recorder = nodes.join(FlightRecorder(link=True, context=nodes.context))
    assert nodes.spin(lambda: listens(recorder))


class FullDisk(FlightBag):
    """On a disk that is full after some messages."""

    written = 0

    def write(self, topic, time, message):
        self.written += 1
        if self.written > 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        super().write(topic, time, message)


def test_a_full_disk_ends_the_bag_and_not_the_flight(nodes, tmp_path):
    bag = FullDisk(tmp_path / "mission.mcap")
    recorder = nodes.join(FlightRecorder(bag, link=True, context=nodes.context))
    publisher = nodes.peer("sender").create_publisher(ODOMETRY.type, ODOMETRY.name, 10)
    state = filled_odometry(1, *circling(0.0))
    also = lambda: publisher.publish(state)  # noqa: E731
    assert nodes.spin(lambda: recorder.heard >= 5, also=also)
    assert bag.written == 3
    assert str(recorder.failure) == f"[Errno 28] No space left on device: '{bag.path}'"


def test_a_message_that_cannot_be_used_ends_no_flight(nodes):
    """While it was looked at, nothing had ever flown: the launch gave up after two minutes."""
    recorder, nowhere = nodes.add(FlightRecorder), [math.nan, 0.0, 50.0, 0.0, 0.0, 10.0]
    state = [100.0, 0.0, 50.0, 0.0, 0.0, 10.0]
    for topic, message in (
        (COMMAND, filled_command(SECOND, [[0.0, 0.0, 0.0]])),
        (ODOMETRY, filled_odometry(2 * SECOND, state)),
        (TARGET, filled_point(SECOND, (0.0, 0.0, 0.0))),
    ):
        recorder._on_message(topic, serialize_message(message))
    before = recorder.progress()
    assert (before.time, before.range) == (1.0, pytest.approx(math.hypot(100.0, 50.0)))
    bad = (ODOMETRY, filled_odometry(3 * SECOND, nowhere)), (TARGET, filled_point(SECOND, nowhere))
    for topic, message in bad:
        recorder._on_message(topic, serialize_message(message))
    assert recorder.progress() == before
