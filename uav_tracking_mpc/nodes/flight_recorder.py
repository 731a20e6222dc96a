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

"""Node ``flight_recorder``: every topic of a flight into an MCAP bag, and where it stands."""

from __future__ import annotations

import contextlib
import functools
import math
import shutil
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node
from rosbags.interfaces import (
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
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.messages.heard_values import VALUES
from uav_tracking_mpc.nodes.messages.wires import deserialized
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription, steady_timer
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    STATIC_TRANSFORMS,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    TRANSFORMS,
    MessageError,
    Quality,
    Topic,
)
from uav_tracking_mpc.report.bag import decoded, typestore

SHOWN = (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, ENGAGED, TRACKING["solve_time"])
FLYING = ("nmpc_controller", "target_publisher", "uav_simulator")  # whose reports are awaited
QUEUE = 1000  # messages of a topic: 10 s of a flight at ten times the wall's speed
METADATA = "metadata.yaml"  # as ROS 2 calls it; who reads bags needs more than a node
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
        self._connections = {
            topic.name: self._writer.add_connection(
                f"/{topic.name.lstrip('/')}",
                topic.type_name,
                typestore=self._store,
                offered_qos_profiles=[_offered(topic.quality)],
            )
            for topic in (*topics, *frames)
        }
        self._named = False  # whether the frames of autopilots are written

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


@dataclass(frozen=True)
class Progress:
    """Where a flight stands.

    Attributes:
        time: Since the first command, or since the autopilot was engaged, in [s]; None before it.
        engaged: Whether a real autopilot flies the commands; None where none says so.
        range: Distance to the target in [m].
        altitude: Height above the target in [m].
        speed: Through the air, over ground where that is not known, in [m/s].
        solve_time: Of the last solve in [s].
    """

    time: float | None = None
    engaged: bool | None = None
    range: float = math.nan
    altitude: float = math.nan
    speed: float = math.nan
    solve_time: float = math.nan


class FlightRecorder(Node):
    """Hears everything and, given a bag, writes it down without decoding it.

    Args:
        bag: Where to write; None only listens.
        link: Whether a real autopilot flies: time is then the wall's, and counts from when it is
            engaged.
        options: As those of rclpy's Node.

    Attributes:
        heard: How many states and commands came.
        failure: Why the bag could not be written on; None while it can.
    """

    def __init__(self, bag: FlightBag | None = None, link: bool = False, **options: Any) -> None:
        super().__init__("flight_recorder", **options)
        self._bag, self._link = bag, link
        self.heard = 0
        self.failure: OSError | None = None
        self._latest: dict[str, bytes] = {}
        self._usable: dict[str, Any] = {}
        self._start: int | None = None
        # The simulator's time may wait for this node: it listens to the state, and so releases
        # the simulator, only when it hears everything else. Both sides must know of each other: a
        # node whose diagnostics come knows who listens to them, and whoever was announced before.
        last = (DIAGNOSTICS, ODOMETRY)
        others = [(topic, self._listen(topic)) for topic in ALL if topic not in last]
        self._needed = [overhearing for topic, overhearing in others if not topic.optional]
        self._unheard = set() if link else {self._status(name) for name in FLYING}
        self._listen(DIAGNOSTICS)
        self._waiting = steady_timer(self, 0.05, self._release)

    def _status(self, node: str) -> str:
        """Name under which a node of this aircraft reports on /diagnostics."""
        return f"{self.get_namespace()}/{node}: status".lstrip("/")

    def _listen(self, topic: Topic) -> FollowingSubscription:
        callback = functools.partial(self._on_message, topic)
        return FollowingSubscription(self, topic, callback, QUEUE, raw=True)

    def _release(self) -> None:
        if self._link or (not self._unheard and all(each.senders for each in self._needed)):
            self._waiting.cancel()
            self._listen(ODOMETRY)

    def _on_message(self, topic: Topic, data: bytes) -> None:
        now = time.time_ns()
        self.heard += topic in (ODOMETRY, COMMAND)
        self._latest[topic.name] = data
        if self._unheard and topic is DIAGNOSTICS:
            self._unheard -= {status.name for status in deserialized(topic, data).status}
        if self._start is None and topic is (ENGAGED if self._link else COMMAND):
            self._begin(deserialized(topic, data), now)
        if self._bag is not None and self.failure is None:
            try:
                self._bag.write(topic, now, data)
            except OSError as error:  # as of a disk that is full; whoever flies flies on
                self.failure = OSError(error.errno, error.strerror, str(self._bag.path))
                self.get_logger().error(f"the bag ends, the flight goes on: {self.failure}")

    def _begin(self, message: Any, now: int) -> None:
        """Count the time from this message on, if it is the one that begins the flight."""
        if not self._link:
            self._start = nanoseconds(message.header.stamp)
        elif message.data:
            self._start = now

    def progress(self) -> Progress:
        """Where the flight stands by the latest messages."""
        state, airspeed, place, tracked, engaged, solve_time = map(self._said, SHOWN)
        if state is None:
            return Progress()
        seen = (where for where in (place, tracked) if where is not None)
        target = next(seen, np.full(3, math.nan))
        return Progress(
            time=None if self._start is None else state.stamp - self._start * 1e-9,
            engaged=engaged,
            range=float(np.linalg.norm(state.position - target)),
            altitude=float(state.position[2] - target[2]),
            speed=math.hypot(*state.ground_velocity) if airspeed is None else airspeed,
            solve_time=math.nan if solve_time is None else solve_time,
        )

    def _said(self, topic: Topic) -> Any:
        """What the latest message of a topic says that can be used; None before the first."""
        if (data := self._latest.pop(topic.name, None)) is not None:
            with contextlib.suppress(MessageError):
                self._usable[topic.name] = VALUES[topic.name](deserialized(topic, data))
        return self._usable.get(topic.name)
