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

"""A flight as an MCAP bag: written message by message, read back as a FlightLog."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from rosbags.interfaces import Connection
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.bag_series import airspeeds, beside_commands, latency, link_figures
from uav_tracking_mpc.nodes.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
    position_from_point,
)
from uav_tracking_mpc.nodes.flown_target import sighted_target, simulated_target
from uav_tracking_mpc.nodes.frame_names import ANY_FRAMES
from uav_tracking_mpc.nodes.offered_quality import offered_quality
from uav_tracking_mpc.nodes.recorded_transform import TYPE, recorded_transform
from uav_tracking_mpc.nodes.reported_mode import mode_changes, reported_mode
from uav_tracking_mpc.nodes.reported_orbit import orbit_changes, reported_orbit
from uav_tracking_mpc.nodes.target_odometry import target_from_odometry
from uav_tracking_mpc.nodes.target_truth import truth_from_odometry
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    Topic,
)
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog

WINGS_LEVEL = 1e-6  # rad; a source that never tells more tells no bank
METADATA = "metadata.yaml"  # as ROS 2 calls it
MOVING = QoSProfile(depth=100)  # as tf2's broadcasters offer
STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


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
        self._writer = Writer(
            self._folder / path.stem,
            version=Writer.VERSION_LATEST,
            storage_plugin=StoragePlugin.MCAP,
        )
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()
        typestore = get_typestore(Stores.ROS2_JAZZY)

        def connect(name: str, kind: str, profile: QoSProfile) -> Connection:
            offered = [offered_quality(profile)]
            return self._writer.add_connection(
                name, kind, typestore=typestore, offered_qos_profiles=offered
            )

        self._connections = {
            topic.name: connect(absolute(topic), topic.type_name, topic.qos) for topic in topics
        }
        if ODOMETRY in topics:
            self._transforms = connect("/tf", TYPE, MOVING)
            self._statics: Connection | None = connect("/tf_static", TYPE, STATIC)  # not yet sent

    def write(self, topic: Topic, time: int, message: bytes) -> None:
        """Append a message.

        Args:
            topic: On which it was sent.
            time: When it was heard in [ns].
            message: Serialized.
        """
        self._writer.write(self._connections[topic.name], time, message)
        if topic is ODOMETRY and (transform := recorded_transform(message)) is not None:
            self._writer.write(self._transforms, time, transform.message())
            if self._statics is not None:
                self._writer.write(self._statics, time, transform.statics())
                self._statics = None

    def close(self) -> None:
        """Complete the file and move it to its place."""
        self._writer.close()
        written = self._folder / self.path.stem
        (written / self.path.name).replace(self.path)
        if self._alone:
            text = (written / METADATA).read_text().replace("distro: rosbags", "distro: jazzy")
            (self.path.parent / METADATA).write_text(text)
        shutil.rmtree(self._folder)

    def discard(self) -> None:
        """Drop what was written; nothing, once the file is complete."""
        shutil.rmtree(self._folder, ignore_errors=True)


def absolute(topic: Topic) -> str:
    """Name of a topic as the bag holds it."""
    return topic.name if topic.name.startswith("/") else f"/{topic.name}"


def messages(path: Path, *topics: Topic) -> Iterator[tuple[Topic, int, Any]]:
    """Messages of a bag, in the order in which they were heard.

    Args:
        path: Of the bag.
        topics: Of which messages are wanted.

    Yields:
        (topic, time in [ns] at which it was heard, message) of each.
    """
    wanted = {absolute(topic): topic for topic in topics}
    with Reader(path) as reader:
        connections = [c for c in reader.connections if c.topic in wanted]
        for connection, time, data in reader.messages(connections):
            topic = wanted[connection.topic]
            yield topic, time, deserialize_message(bytes(data), topic.type)


class _Contents:
    """What a bag holds of a flight, message by message.

    Args:
        path: Of the bag.

    Attributes:
        states: Stamp in [ns] and motion of each state.
        commands: Stamp in [ns] and first inputs of each command.
        airspeeds: Stamp in [ns] and airspeed in [m/s] of each air velocity.
        heard: Wall time in [ns] at which the recorder heard each state.
        sent: Wall time in [ns] at which it heard each command.
        values: Wall time in [ns] and value of the figures ``cost`` and ``solve_time``.
        sightings: Stamp in [ns] and position of each measurement of the target.
        truths: Stamp in [ns], position and velocity of what a simulated target says of itself.
        orbits: Stamp in [ns] and orbit of each report of the controller.
        modes: Stamp in [ns], mode and reason of each report of the controller.
        engaged: Wall time in [ns] at which an autopilot first flew the commands; None if none did.
        reports: Latest diagnostics of each node.
        unusable: How many messages were left out: not finite, or of no place on this earth.
    """

    def __init__(self, path: Path) -> None:
        self.states: list[tuple[int, Measurement]] = []
        self.commands: list[tuple[int, NDArray[np.float64]]] = []
        self.airspeeds: list[tuple[int, float]] = []
        self.heard: list[int] = []
        self.sent: list[int] = []
        self.values: dict[str, list[tuple[int, float]]] = {"cost": [], "solve_time": []}
        self.sightings: list[tuple[int, NDArray[np.float64]]] = []
        self.truths: list[tuple[int, NDArray[np.float64], NDArray[np.float64]]] = []
        self.orbits: list[tuple[int, Orbit]] = []
        self.modes: list[tuple[int, FallbackMode, str]] = []
        self.engaged: int | None = None
        self.unusable = 0
        self.reports: dict[str, dict[str, str]] = {}
        figures = {TRACKING[name].name: name for name in self.values}
        topics = (
            ODOMETRY,
            AIR_VELOCITY,
            COMMAND,
            ENGAGED,
            TARGET,
            TARGET_ODOMETRY,
            TARGET_TRUTH,
            DIAGNOSTICS,
            *(TRACKING[name] for name in self.values),
        )
        for topic, time, message in messages(path, *topics):
            if topic.name in figures:
                self.values[figures[topic.name]].append((time, message.data))
                continue
            try:
                self._take(topic, time, message)
            except ValueError:  # of a message
                self.unusable += 1

    def commands_from(
        self, start: int, end: int
    ) -> tuple[list[tuple[int, NDArray[np.float64]]], list[int]]:
        """Commands of a time, and when the recorder heard each.

        Args:
            start: First stamp in [ns].
            end: Last stamp in [ns].
        """
        pairs = zip(self.commands, self.sent, strict=True)
        chosen = [(command, sent) for command, sent in pairs if start <= command[0] <= end]
        return [command for command, _ in chosen], [sent for _, sent in chosen]

    def _take(self, topic: Topic, time: int, message: Any) -> None:
        if topic is DIAGNOSTICS:
            for status in message.status:
                node = status.name.partition(":")[0].rpartition("/")[2]
                self.reports[node] = {entry.key: entry.value for entry in status.values}
                stamp = nanoseconds(message.header.stamp)
                if (orbit := reported_orbit(self.reports[node])) is not None:
                    self.orbits.append((stamp, orbit))
                if (mode := reported_mode(self.reports[node])) is not None:
                    self.modes.append((stamp, *mode))
            return
        if topic is TARGET_TRUTH:
            self.truths.append(truth_from_odometry(message))
            return
        if topic is ENGAGED:
            if message.data and self.engaged is None:
                self.engaged = time
            return
        stamp = nanoseconds(message.header.stamp)
        if topic is ODOMETRY:
            self.states.append((stamp, measurement_from_odometry(message, frames=ANY_FRAMES)))
            self.heard.append(time)
        elif topic is AIR_VELOCITY:
            speed = float(np.linalg.norm(air_velocity_from_twist(message, ANY_FRAMES)))
            self.airspeeds.append((stamp, speed))
        elif topic is TARGET:
            self.sightings.append((stamp, position_from_point(message, ANY_FRAMES)))
        elif topic is TARGET_ODOMETRY:
            self.sightings.append((stamp, target_from_odometry(message, ANY_FRAMES).position))
        else:
            inputs, _ = plan_from_command(message, ANY_FRAMES)
            self.commands.append((stamp, inputs[0]))
            self.sent.append(time)


def flight_log(path: Path, configuration: Configuration) -> FlightLog:
    """Record of a flight from its bag; time counts from the first command.

    With a real autopilot it counts from when that was engaged. The vehicle's motion is as measured;
    the target's is the true one, or what a target over MAVLink said of itself. A bag without
    ``uav/air_velocity`` is read as flown in still air.

    Args:
        path: Of the bag.
        configuration: What was flown.

    Raises:
        ValueError: The bag holds no command, or none was flown.
    """
    bag = _Contents(path)
    if not bag.commands:
        raise ValueError(f"bag {path} holds no command: the controller never flew")
    start, link = bag.commands[0][0], bag.reports.get("autopilot_link")
    if link is not None:
        if bag.engaged is None:
            raise ValueError(f"bag {path} holds no flown command: the autopilot was never engaged")
        start = bag.engaged
    end = start + round(configuration.mission.duration * 1e9)
    flown = [(stamp, motion) for stamp, motion in bag.states if start <= stamp <= end]
    commands, sent = bag.commands_from(start, end)
    # An interrupted flight is as long as it was flown; a whole one may lack its last state.
    span = (flown[-1][0] - start) * 1e-9 if flown else 0.0
    span += 1.0 / configuration.simulator.state_rate
    controller = bag.reports.get("nmpc_controller", {})
    simulator = bag.reports.get("uav_simulator", {})
    tracking, stamps = configuration.controller, [stamp for stamp, _ in flown]
    if link is not None and configuration.link.target_system:
        target = sighted_target(bag.sightings, stamps)
    else:
        began = int(bag.reports.get("target_publisher", {}).get("began [ns]", 0))
        target = simulated_target(configuration.target, began, stamps, bag.truths)
    # With the nearest direction asked for, the controller tells which one it chose.
    direction = controller.get("direction", tracking.orbit.direction)
    orbit = replace(tracking.orbit, direction=direction)
    orbits = orbit_changes(bag.orbits, start)
    modes = (FallbackMode.LOITER, FallbackMode.HOLD)
    unplanned = (int(controller.get(f"mode {mode.value}", 0)) for mode in modes)
    vehicle = [
        motion.state(speed)
        for (_, motion), speed in zip(flown, airspeeds(flown, bag.airspeeds), strict=True)
    ]
    banks = np.array([motion.bank for _, motion in flown])
    return FlightLog(
        config=configuration.name,
        duration=min(configuration.mission.duration, span),
        speed=float(simulator.get("speed", configuration.mission.speed)),
        model=tracking.model,
        plant=configuration.simulator.plant if link is None else configuration.link.link,
        orbit=orbits[-1][1] if orbits else orbit,
        orbits=orbits,
        input_lower=tracking.input_lower,
        input_upper=tracking.input_upper,
        time=np.array([(stamp - start) * 1e-9 for stamp, _ in flown]),
        vehicle=np.array(vehicle),
        target=target.position,
        command_time=np.array([(stamp - start) * 1e-9 for stamp, _ in commands]),
        inputs=np.array([inputs for _, inputs in commands]),
        cost=beside_commands(sent, bag.values["cost"]),
        solve_time=beside_commands(sent, bag.values["solve_time"]),
        solver=controller.get("solver", tracking.solver),
        failures=int(controller.get("solver failures", 0)),
        commands=CommandCounts(
            # The last report may be older than the last command, or lost with its node.
            sent=max(int(controller.get("commands sent", 0)), len(commands)),
            late=int(controller.get("commands late", 0)),
            plan_reused=int(controller.get("plan reused", 0)),
            failsafe=int(simulator.get("failsafe", 0)) + sum(unplanned),
        ),
        latency=latency(
            [(stamp, time) for (stamp, _), time in zip(bag.states, bag.heard, strict=True)],
            [(stamp, time) for (stamp, _), time in zip(bag.commands, bag.sent, strict=True)],
        ),
        ground_velocity=np.array([motion.ground_velocity for _, motion in flown]),
        target_velocity=target.velocity,
        turn_rate=np.array([motion.turn_rate for _, motion in flown]),
        measured_bank=banks if np.abs(banks).max(initial=0.0) > WINGS_LEVEL else None,
        unusable=bag.unusable,
        modes=mode_changes(bag.modes, start, end),
        tracking=tracking,
        link=None if link is None else link_figures(link),
    )
