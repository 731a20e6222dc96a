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

"""What the nodes of a recorded aircraft said of themselves at a time: ``/diagnostics`` of a bag."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.recorded.recorded_topic import SECOND, Place, RecordedTopic
from uav_tracking_mpc.view.sight import NodeStatus

GONE = 5 * SECOND  # ns after which a node that reports once a second is silent
FORGOTTEN = 60 * SECOND  # ns after which a silent one is not shown
SILENT = 3  # level, as of diagnostic_msgs
MODES = {mode.value: mode for mode in FallbackMode}


class Told(NamedTuple):
    """A report of a node.

    Attributes:
        namespace: Of its aircraft, without slashes around it.
        status: What it said.
    """

    namespace: str
    status: NodeStatus


class RecordedStatuses:
    """Reports of the nodes of one aircraft.

    Args:
        topic: ``/diagnostics``.
        namespace: Of the aircraft, without slashes around it.
        read: Reports of the message at a place of the topic.
    """

    def __init__(
        self, topic: RecordedTopic, namespace: str, read: Callable[[Place], tuple[Told, ...]]
    ) -> None:
        self._topic, self._namespace, self._read = topic, namespace, read

    def at(self, time: int, within: int = FORGOTTEN) -> dict[str, NodeStatus]:
        """The newest report of each node, by its name.

        Args:
            time: In [ns] by the recorder's clock.
            within: How old they may be in [ns].
        """
        found: dict[str, NodeStatus] = {}
        place = self._topic.newest(time)
        while place is not None and (age := time - self._topic.heard(place)) <= within:
            for namespace, status in self._read(place):
                if namespace == self._namespace and status.node not in found:
                    found[status.node] = replace(status, level=SILENT) if age > GONE else status
            place = self._topic.before(place)
        return dict(sorted(found.items()))

    def of(self, node: str, time: int) -> NodeStatus | None:
        """The newest report of a node; None where there is none that is not too old.

        Args:
            node: Its name.
            time: In [ns] by the recorder's clock.
        """
        place = self._topic.newest(time)
        while place is not None and time - self._topic.heard(place) <= GONE:
            for namespace, status in self._read(place):
                if (namespace, status.node) == (self._namespace, node):
                    return status
            place = self._topic.before(place)
        return None


def told(message: Any) -> tuple[Told, ...]:
    """Reports of a message.

    Args:
        message: ``diagnostic_msgs/msg/DiagnosticArray``.
    """
    reports = []
    for status in message.status:
        namespace, _, node = status.name.partition(":")[0].strip("/").rpartition("/")
        values = {entry.key: entry.value for entry in status.values}
        level = int(status.level)
        reports.append(Told(namespace, NodeStatus(node, level, status.message, values)))
    return tuple(reports)


def reported_mode(values: Mapping[str, str]) -> tuple[FallbackMode | None, str]:
    """What is flown and why it is not optimal, as a controller tells; None where it tells nothing.

    Args:
        values: Of its diagnostics.
    """
    return MODES.get(values.get("mode", "")), values.get("mode reason", "")
