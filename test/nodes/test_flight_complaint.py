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

"""What the nodes of a recorded flight complained of last."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from uav_tracking_mpc.nodes.conversions import set_command, set_odometry, set_stamp
from uav_tracking_mpc.nodes.flight_bag import FlightBag
from uav_tracking_mpc.nodes.flight_complaint import last_complaint
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
SECOND = 1_000_000_000


def complaint(path, *said, last_state=10):
    """Of a bag with a state a second, the first command at 1 s, and what nodes said when."""
    bag = FlightBag(path)
    for second in range(20):
        if second <= last_state:
            message = ODOMETRY.type()
            set_odometry(message, second * SECOND, np.array([9.0] * 6), np.zeros(3))
            bag.write(ODOMETRY, second * SECOND, serialize_message(message))
        if second == 1:
            message = COMMAND.type()
            set_command(message, second * SECOND, np.zeros((2, 3)), 1.0)
            bag.write(COMMAND, second * SECOND, serialize_message(message))
        for when, node, level, words, *reason in said:
            if when == second:
                values = [KeyValue(key="mode reason", value=text) for text in reason]
                status = DiagnosticStatus(level=level, message=words, values=values)
                status.name = f"{node}: status"
                message = DIAGNOSTICS.type(status=[status])
                set_stamp(message.header.stamp, second * SECOND)
                bag.write(DIAGNOSTICS, second * SECOND + 1, serialize_message(message))
    bag.close()
    found = last_complaint(path)
    return None if found is None else str(found)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ([], None),
        ([(2, "pilot", OK, "fine")], None),
        (
            [(2, "red/pilot", ERROR, "two of them"), (3, "red/pilot", OK, "fine")],
            "red/pilot said at 1.0 s: two of them",
        ),
        (
            [(2, "pilot", ERROR, "loiter", "target lost"), (5, "vehicle", WARN, "holding")],
            "pilot said at 1.0 s: loiter (target lost)",
        ),
        ([(2, "pilot", WARN, "slow"), (3, "pilot", OK, "fine")], None),
        (
            [(2, "pilot", WARN, "slow"), (3, "pilot", DiagnosticStatus.STALE, "ended")],
            "pilot said at 1.0 s: slow",
        ),
        ([(2, "pilot", WARN, "slow"), (3, "other", OK, "fine")], "pilot said at 1.0 s: slow"),
    ],
)
def test_the_last_error_counts_else_a_warning_that_stands(tmp_path, said, words):
    assert complaint(tmp_path / "flight.mcap", *said) == words


def test_what_is_said_when_the_nodes_end_counts_for_nothing(tmp_path):
    said = (12, "pilot", ERROR, "vehicle state is lost")
    assert complaint(tmp_path / "flight.mcap", said) is None
