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

"""A flight as an MCAP bag, written message by message."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.rosbag2.storage_mcap import McapWriter

from uav_tracking_mpc.dynamics.frames import FORWARD_RIGHT_DOWN, NORTH_EAST_DOWN
from uav_tracking_mpc.nodes.topics import (
    ALL,
    ODOMETRY,
    STATIC_TRANSFORMS,
    TRANSFORMS,
    Quality,
    Topic,
)
from uav_tracking_mpc.report.bag import decoded, typestore

METADATA = "metadata.yaml"  # as ROS 2 calls it
INFINITE = QosTime(*divmod(2**63 - 1, 10**9))
HERE = (0.0, 0.0, 0.0)  # m, translation to a frame with other axes alone

Frame = tuple[str, str, Sequence[float], Sequence[float]]  # parent, child, position, quaternion


class FlightBag:
    """Bag being written: one MCAP file, moved to its place when it is complete.

    Where it holds ``uav/odometry``, it also holds the aircraft's transform on ``/tf`` and the
    frames of autopilots on ``/tf_static``.

    Args:
        path: The file to write; replaced if it exists.
        topics: What it may hold.
        alone: It is the only bag in its folder: ``metadata.yaml`` is put beside it, by which the
            folder is a bag of ROS 2.

    Raises:
        OSError: The folder cannot be written.
    """

    def __init__(self, path: Path, topics: Sequence[Topic] = ALL, alone: bool = False) -> None:
        self.path, self._alone = path, alone
        path.parent.mkdir(parents=True, exist_ok=True)
        self._folder = Path(tempfile.mkdtemp(prefix=".recording-", dir=path.parent))
        # The metadata name the file after the folder in which it is written.
        self._writer = _Writer(
            self._folder / path.stem,
            version=Writer.VERSION_LATEST,
            storage_plugin=StoragePlugin.MCAP,
        )
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()
        self._store = typestore()
        frames = (TRANSFORMS, STATIC_TRANSFORMS) if ODOMETRY in topics else ()
        self._connections = {topic.name: self._connect(topic) for topic in (*topics, *frames)}
        self._named = False  # whether the frames of autopilots are written

    def _connect(self, topic: Topic) -> Connection:
        return self._writer.add_connection(
            f"/{topic.name.lstrip('/')}",
            topic.type_name,
            typestore=self._store,
            offered_qos_profiles=[_offered(topic.quality)],
        )

    def write(self, topic: Topic, time: int, message: bytes) -> None:
        """Append a message.

        Args:
            topic: On which it was sent.
            time: When it was heard in [ns].
            message: Serialized.
        """
        self._writer.write(self._connections[topic.name], time, message)
        if topic is ODOMETRY:
            self._write_transforms(time, message)

    def _write_transforms(self, time: int, odometry: bytes) -> None:
        """The transform that a state says, and once the frames of autopilots beside its two."""
        try:
            state = decoded(odometry, ODOMETRY.type_name)
        except ValueError:  # who published it sent no such message
            return
        place, turn, header = state.pose.pose.position, state.pose.pose.orientation, state.header
        position, rotation = (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)
        if not all(map(math.isfinite, (*position, *rotation))):
            return
        frames = [(header.frame_id, state.child_frame_id, position, rotation)]
        self._write_frames(TRANSFORMS, time, header, frames)
        if not self._named:
            self._named = True
            frames = [
                (header.frame_id, f"{header.frame_id}_ned", HERE, NORTH_EAST_DOWN),
                (state.child_frame_id, f"{state.child_frame_id}_frd", HERE, FORWARD_RIGHT_DOWN),
            ]
            self._write_frames(STATIC_TRANSFORMS, time, header, frames)

    def _write_frames(self, topic: Topic, time: int, header: Any, frames: Sequence[Frame]) -> None:
        types = self._store.types
        transforms = [
            types["geometry_msgs/msg/TransformStamped"](
                replace(header, frame_id=parent),
                child,
                types["geometry_msgs/msg/Transform"](
                    types["geometry_msgs/msg/Vector3"](*position),
                    types["geometry_msgs/msg/Quaternion"](*rotation),
                ),
            )
            for parent, child, position, rotation in frames
        ]
        message = types[topic.type_name](transforms)
        data = self._store.serialize_cdr(message, topic.type_name)
        self._writer.write(self._connections[topic.name], time, data)

    def close(self) -> None:
        """Complete the file and move it to its place."""
        self._writer.close()
        written = self._folder / self.path.stem
        (written / self.path.name).replace(self.path)
        if self._alone:
            text = _by_jazzy((written / METADATA).read_text())
            (self.path.parent / METADATA).write_text(text)
        shutil.rmtree(self._folder)

    def discard(self) -> None:
        """Drop what was written; nothing, once the file is complete."""
        shutil.rmtree(self._folder, ignore_errors=True)


class _File(McapWriter):
    """Keeps in the file the same metadata as stand beside it."""

    def close(self, version: int, metadata: str) -> None:
        super().close(version, _by_jazzy(metadata))


class _Writer(Writer):
    STORAGE_PLUGINS: Mapping[StoragePlugin, type[Any]] = {StoragePlugin.MCAP: _File}


def _by_jazzy(metadata: str) -> str:
    """Metadata in which rosbags has named itself in the place of the distribution."""
    return metadata.replace("distro: rosbags", "distro: jazzy")


def _offered(quality: Quality) -> Qos:
    """What a bag says that was offered; ``ros2 bag play`` publishes with it."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=quality.depth,
        reliability=(QosReliability.RELIABLE if quality.reliable else QosReliability.BEST_EFFORT),
        durability=QosDurability.TRANSIENT_LOCAL if quality.kept else QosDurability.VOLATILE,
        deadline=INFINITE,
        lifespan=QosTime(quality.lifespan, 0) if quality.lifespan else INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=INFINITE,
        avoid_ros_namespace_conventions=False,
    )
