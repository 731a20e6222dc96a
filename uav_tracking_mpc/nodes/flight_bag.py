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
from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.relative import steady_inputs
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
)
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    TRACKING,
    Topic,
)
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.flight_log import CommandCounts, FlightLog, Latency
from uav_tracking_mpc.simulation.target_motion import target_position, target_velocity


class FlightBag:
    """Bag being written: one MCAP file, moved to its place when it is complete.

    Args:
        path: The file to write; replaced if it exists.
        topics: What it may hold.

    Raises:
        OSError: The folder cannot be written.
    """

    def __init__(self, path: Path, topics: Sequence[Topic] = ALL) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._folder = Path(tempfile.mkdtemp(prefix=".recording-", dir=path.parent))
        self._writer = Writer(
            self._folder / "bag", version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP
        )
        self._writer.open()
        typestore = get_typestore(Stores.ROS2_JAZZY)
        self._connections = {
            topic.name: self._writer.add_connection(
                absolute(topic), topic.type_name, typestore=typestore
            )
            for topic in topics
        }

    def write(self, topic: Topic, time: int, message: bytes) -> None:
        """Append a serialized message, sent at ``time`` [ns]."""
        self._writer.write(self._connections[topic.name], time, message)

    def close(self) -> None:
        """Complete the file and move it to its place."""
        self._writer.close()
        (recorded,) = (self._folder / "bag").glob("*.mcap")
        recorded.replace(self.path)
        shutil.rmtree(self._folder)

    def discard(self) -> None:
        """Drop what was written."""
        shutil.rmtree(self._folder, ignore_errors=True)


def absolute(topic: Topic) -> str:
    """Name of a topic as the bag holds it."""
    return topic.name if topic.name.startswith("/") else f"/{topic.name}"


def messages(path: Path, *topics: Topic) -> Iterator[tuple[Topic, int, Any]]:
    """(topic, time sent [ns], message) of a bag, in the order they were sent."""
    wanted = {absolute(topic): topic for topic in topics}
    with Reader(path) as reader:
        connections = [c for c in reader.connections if c.topic in wanted]
        for connection, time, data in reader.messages(connections):
            topic = wanted[connection.topic]
            yield topic, time, deserialize_message(bytes(data), topic.type)


def flight_log(path: Path, configuration: Configuration) -> FlightLog:
    """Record of a flight from its bag; time counts from the first command.

    The vehicle's motion is as measured; the target's is the true one, a function of simulated time
    alone. A bag without ``uav/air_velocity`` is read as flown in still air.

    Raises:
        ValueError: The bag holds no command.
    """
    states: list[tuple[int, Measurement]] = []
    commands = []
    airspeeds: list[tuple[int, float]] = []
    heard, sent = [], []  # wall time at which the recorder heard each of them [ns]
    values: dict[str, list[tuple[int, float]]] = {"cost": [], "solve_time": []}
    by_name = {TRACKING[name].name: name for name in values}
    reports: dict[str, dict[str, str]] = {}
    topics = (ODOMETRY, AIR_VELOCITY, COMMAND, DIAGNOSTICS, *(TRACKING[name] for name in values))
    for topic, time, message in messages(path, *topics):
        if topic is ODOMETRY:
            states.append((nanoseconds(message.header.stamp), measurement_from_odometry(message)))
            heard.append(time)
        elif topic is AIR_VELOCITY:
            speed = float(np.linalg.norm(air_velocity_from_twist(message)))
            airspeeds.append((nanoseconds(message.header.stamp), speed))
        elif topic is COMMAND:
            commands.append((nanoseconds(message.header.stamp), plan_from_command(message)[0][0]))
            sent.append(time)
        elif topic is DIAGNOSTICS:
            for status in message.status:
                node = status.name.partition(":")[0].rpartition("/")[2]
                reports[node] = {entry.key: entry.value for entry in status.values}
        else:
            values[by_name[topic.name]].append((time, message.data))
    if not commands:
        raise ValueError(f"bag {path} holds no command: the controller never flew")
    start = commands[0][0]
    end = start + round(configuration.mission.duration * 1e9)
    flown = [(stamp, motion) for stamp, motion in states if start <= stamp <= end]
    simulated = [stamp * 1e-9 for stamp, _ in flown]
    latency = _latency(states, commands, heard, sent)
    within = sum(stamp <= end for stamp, _ in commands)
    commands, sent = commands[:within], sent[:within]
    # An interrupted flight is as long as it was flown; a whole one may lack its last state.
    span = (flown[-1][0] - start) * 1e-9 if flown else 0.0
    span += 1.0 / configuration.simulator.state_rate
    controller, simulator = reports.get("nmpc_controller", {}), reports.get("uav_simulator", {})
    tracking = configuration.controller
    # With the nearest direction asked for, the controller tells which one it chose.
    direction = controller.get("direction", tracking.orbit.direction)
    orbit = replace(tracking.orbit, direction=direction)
    return FlightLog(
        config=configuration.name,
        duration=min(configuration.mission.duration, span),
        speed=configuration.mission.speed,
        model=tracking.model,
        plant="vehicle",
        orbit=orbit,
        input_lower=tracking.input_lower,
        input_upper=tracking.input_upper,
        steady_inputs=steady_inputs(tracking.model, orbit),
        time=np.array([(stamp - start) * 1e-9 for stamp, _ in flown]),
        vehicle=np.array(
            [
                motion.state(speed)
                for (_, motion), speed in zip(flown, _airspeeds(flown, airspeeds), strict=True)
            ]
        ),
        target=np.array([target_position(configuration.target, t) for t in simulated]),
        command_time=np.array([(stamp - start) * 1e-9 for stamp, _ in commands]),
        inputs=np.array([inputs for _, inputs in commands]),
        cost=_beside_commands(sent, values["cost"]),
        solve_time=_beside_commands(sent, values["solve_time"]),
        solver=controller.get("solver", tracking.solver),
        failures=int(controller.get("solver failures", 0)),
        commands=CommandCounts(
            sent=int(controller.get("commands sent", len(commands))),
            late=int(controller.get("commands late", 0)),
            plan_reused=int(controller.get("plan reused", 0)),
            failsafe=int(simulator.get("failsafe", 0))
            + sum(
                int(controller.get(f"mode {mode.value}", 0))
                for mode in (FallbackMode.LOITER, FallbackMode.HOLD)
            ),
        ),
        latency=latency,
        ground_velocity=np.array([motion.ground_velocity for _, motion in flown]),
        target_velocity=np.array([target_velocity(configuration.target, t) for t in simulated]),
    )


def _airspeeds(
    flown: list[tuple[int, Measurement]], measured: list[tuple[int, float]]
) -> NDArray[np.float64]:
    """Airspeed at each state, shape (n,), in [m/s]; of still air where none was measured."""
    if not measured:
        return np.array([np.linalg.norm(motion.ground_velocity) for _, motion in flown])
    stamps, speeds = zip(*sorted(measured), strict=True)
    first = stamps[0]  # differences keep their nanoseconds as floats
    return np.interp(
        [stamp - first for stamp, _ in flown], [stamp - first for stamp in stamps], speeds
    )


def _latency(states: list, commands: list, heard: list[int], sent: list[int]) -> Latency | None:
    """From a state on the wire to the command computed from it, as the recorder heard them.

    A command bears the stamp of its state. Simulated stamps are no wall time, hence the detour.
    """
    arrival = {stamp: time for (stamp, _), time in zip(states, heard, strict=True)}
    delays = [
        (time - arrival[stamp]) * 1e-3
        for (stamp, _), time in zip(commands, sent, strict=True)
        if stamp in arrival
    ]
    if not delays:
        return None
    median, p99 = np.percentile(delays, [50.0, 99.0])
    return Latency(median=float(median), p99=float(p99), max=float(max(delays)))


def _beside_commands(sent: list[int], values: list[tuple[int, float]]) -> NDArray[np.float64]:
    """Values in the order of the commands: each was sent right after its command."""
    beside = np.full(len(sent), np.nan)
    for time, value in values:
        index = int(np.searchsorted(sent, time, side="right")) - 1
        if index >= 0:
            beside[index] = value
    return beside
