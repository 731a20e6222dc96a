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

"""All aircraft of a bag, whoever recorded it: found by their topics. Needs no ROS."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

from uav_tracking_mpc.control.record import recorded_parameters
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.recorded.bag_chunks import BagChunks
from uav_tracking_mpc.view.recorded.bag_index import BagError, BagIndex, read_bag
from uav_tracking_mpc.view.recorded.recorded_figures import COMMAND, FIGURES, ODOMETRY
from uav_tracking_mpc.view.recorded.recorded_flight import RecordedFlight
from uav_tracking_mpc.view.recorded.recorded_time import RecordedTime
from uav_tracking_mpc.view.recorded.recorded_topic import RecordedTopic
from uav_tracking_mpc.view.watched_flight import FlightSource

logger = logging.getLogger(__name__)

RECORD = "controller.jsonl"  # as `fly` calls it
SHARED = "/"  # in the place of a namespace: topics of all aircraft
NAMED = 8  # topics that a message names


class RecordedSource(FlightSource):
    """Aircraft of a bag.

    Args:
        path: Of the bag, an MCAP file or the folder of a recorder.
        tracking: What the controllers flew by; None takes what the controller of a single aircraft
            recorded beside the bag, if it did.

    Raises:
        BagError: It is no bag, is cut off or damaged, or holds no aircraft.
        OSError: It cannot be read.
    """

    def __init__(self, path: Path, tracking: TrackingParameters | None = None) -> None:
        index = read_bag(path)
        names = _topics(index)
        self._chunks = BagChunks(index, {k: index.channels[k].topic for k in names})
        topics: dict[str, dict[str, RecordedTopic]] = {}
        for number, (namespace, name) in names.items():
            topic = RecordedTopic(index.channels[number].topic, index, self._chunks)
            topics.setdefault(namespace, {})[name] = topic
        shared = topics.get(SHARED, {})
        flown = {
            namespace: {**own, **shared}
            for namespace, own in sorted(topics.items())
            if ODOMETRY in own and own[ODOMETRY].first is not None
        }
        if not flown:
            self.close()
            raise BagError(_nothing(index))
        if tracking is None and len(flown) == 1:
            tracking = _recorded_beside(path)
        time = RecordedTime(
            [own[ODOMETRY] for own in flown.values()],
            [own[COMMAND] for own in flown.values() if COMMAND in own],
        )
        self.clock = time.clock
        self._flights = [
            RecordedFlight(namespace, own, time, tracking) for namespace, own in flown.items()
        ]

    def flights(self) -> Sequence[RecordedFlight]:
        """All of them."""
        return self._flights

    def close(self) -> None:
        """Close the bag."""
        self._chunks.close()


def _topics(index: BagIndex) -> dict[int, tuple[str, str]]:
    """Namespace without slashes around it, and name of the topic, of each channel that is read."""
    found = {}
    for number, (topic, kind) in index.channels.items():
        for name, figure in FIGURES.items():
            if kind != figure.kind:
                continue
            if name.startswith("/"):
                if topic == name:
                    found[number] = SHARED, name
            elif f"/{topic.lstrip('/')}".endswith(f"/{name}"):
                found[number] = f"/{topic.lstrip('/')}"[: -len(name)].strip("/"), name
    return found


def _recorded_beside(path: Path) -> TrackingParameters | None:
    """What the controller recorded beside the bag; None where it did not, or unreadably."""
    record = path / RECORD if path.is_dir() else path.with_name(RECORD)
    if not record.is_file():
        return None
    try:
        return recorded_parameters(record)
    except (ValueError, OSError) as error:
        logger.warning("the limits are not shown: %s cannot be read: %s", record, error)
        return None


def _nothing(index: BagIndex) -> str:
    """That there is no aircraft, and what there is instead."""
    topics = sorted({channel.topic for channel in index.channels.values()})
    held = ", ".join(topics[:NAMED]) + (", ..." if len(topics) > NAMED else "")
    return (
        f"bag {index.path} holds no aircraft: no message on a topic {ODOMETRY} of type "
        f"{FIGURES[ODOMETRY].kind}; its topics are {held or 'none of ROS 2'}"
    )
