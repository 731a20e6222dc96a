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

"""What the nodes of a recorded flight complained of last: why it may not have settled."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from uav_tracking_mpc.nodes.conversions import nanoseconds
from uav_tracking_mpc.nodes.diagnostics import ERROR, OK, STALE, WARN
from uav_tracking_mpc.nodes.flight_bag import messages
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY

REASON = "mode reason"  # value of the controller that says more than its message


class Complaint(NamedTuple):
    """A status that was not fine.

    Attributes:
        node: Whose it was.
        time: Since the first command in [s]; None where there was none.
        words: What it said.
    """

    node: str
    time: float | None
    words: str

    def __str__(self) -> str:
        """For people."""
        when = "" if self.time is None else f" at {self.time:.1f} s"
        return f"{self.node} said{when}: {self.words}"


def last_complaint(path: Path) -> Complaint | None:
    """The last error that any node reported; without one, a warning that stood at the end.

    What is said after the last state counts for nothing: the nodes end one after the other.

    Args:
        path: Of the bag.
    """
    start: int | None = None
    waiting: list[tuple[int, Any]] = []  # what was said since the latest state
    standing: dict[str, tuple[int, Any]] = {}  # the latest status of each node
    error: tuple[int, Any] | None = None
    for topic, _, message in messages(path, COMMAND, ODOMETRY, DIAGNOSTICS):
        if topic is COMMAND:
            start = nanoseconds(message.header.stamp) if start is None else start
        elif topic is DIAGNOSTICS:
            stamp = nanoseconds(message.header.stamp)
            waiting += [(stamp, each) for each in message.status if each.level != STALE]
        else:
            for said in waiting:
                standing[said[1].name] = said
                error = said if said[1].level == ERROR else error
            waiting.clear()
    warnings = [said for said in standing.values() if said[1].level == WARN]
    last = error or max(warnings, key=lambda said: said[0], default=None)
    return None if last is None else _complaint(*last, start)


def _complaint(stamp: int, status: Any, start: int | None) -> Complaint:
    values = {value.key: value.value for value in status.values}
    reason = values.get(REASON, "") if status.level != OK else ""
    words = f"{status.message} ({reason})" if reason and reason not in status.message else None
    return Complaint(
        status.name.partition(":")[0],
        None if start is None else (stamp - start) * 1e-9,
        words or status.message,
    )
