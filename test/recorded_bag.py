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

"""Bags of a flight about a target that drives on, with every topic, made by the real writer."""

import itertools
import struct
from dataclasses import replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from filled_messages import (
    filled_air,
    filled_clock,
    filled_odometry,
    filled_orbit,
    filled_point,
    filled_status,
)
from mcap.reader import make_reader
from mcap.writer import Writer
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.orbit import Orbit, orbit_about
from uav_tracking_mpc.nodes.controller_report import markers_message, path_message
from uav_tracking_mpc.nodes.flight_recorder import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import set_stamp, set_truth
from uav_tracking_mpc.nodes.messages.diagnostic_values import orbit_values
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS, MODES, tracking_message
from uav_tracking_mpc.nodes.messages.wires import CommandWire
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    CLOCK,
    COMMAND,
    DIAGNOSTICS,
    MARKERS,
    ODOMETRY,
    ORBIT,
    PREDICTED_PATH,
    TARGET,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
)

STAMPED = [topic for topic in ALL if "header" in topic.type.get_fields_and_field_types()]
STAMP, STAMP_AT, SECOND = struct.Struct("<iI"), 4, 1_000_000_000
WALL = 1_700_000_000_000_000_000  # ns
STAGES, STEP = 20, 0.5  # of a plan; [s]
COMMAND_DELAY, DIAGNOSTIC_DELAY = 4_000_000, 1_000_000  # ns from a state to what answers it
ORBIT_WANTED = Orbit(300.0, 120.0, 22.0, "counter_clockwise")
WIND = np.array([4.0, -2.0, 0.0])
TARGET_VELOCITY = np.array([3.0, 1.0, 0.0])
STD, TARGET_STD = 0.5, 0.2  # m of the target's measurements and of its estimate
FALLBACK = "loiter law", "target position is lost"
OPTIMAL = "optimal plan", ""


class SyntheticFlight:
    """A circle about a target on a straight road, without end.

    Args:
        turn: At the begin in [rad].
    """

    def __init__(self, turn=0.0):
        self._turn = turn
        self._rate = ORBIT_WANTED.speed / ORBIT_WANTED.radius

    def target(self, time):
        return TARGET_VELOCITY * time

    def vehicle(self, time):
        """(x, y, z, psi, chi, v)."""
        angle = self._turn + self._rate * time
        circle = ORBIT_WANTED.radius * np.array([np.cos(angle), np.sin(angle)])
        x, y = self.target(time)[:2] + circle
        return np.array([x, y, ORBIT_WANTED.altitude, angle + np.pi / 2.0, 0.0, ORBIT_WANTED.speed])

    def ground_velocity(self, time):
        *_, heading, _, speed = self.vehicle(time)
        return speed * np.array([np.cos(heading), np.sin(heading), 0.0]) + WIND

    def plan(self, time):
        return np.array([self.vehicle(time + k * STEP) for k in range(STAGES + 1)])

    @property
    def turn_rate(self):
        return self._rate


def mode_at(time, fallbacks):
    """Mode and reason, given the times [s] at which each fallback begins and ends."""
    return FALLBACK if any(begin <= time < end for begin, end in fallbacks) else OPTIMAL


def write_bag(
    path,
    duration,
    namespaces=("",),
    state_rate=50,
    command_rate=20,
    speed=1.0,
    start=0,
    fallbacks=(),
    silence=(),
    topics=ALL,
):
    """Write a bag.

    Args:
        path: Of the file.
        duration: In [s] of the flight.
        namespaces: Of the aircraft.
        state_rate: In [Hz].
        command_rate: In [Hz].
        speed: Simulated over wall time.
        start: First stamp in [ns].
        fallbacks: (begin, end) of times in [s] at which the loiter law is flown.
        silence: (begin, end) of times in [s] at which no controller is there.
        topics: That the bag holds.
    """
    shared = [topic for topic in topics if topic.name.startswith("/")]
    named = {
        namespace: {
            topic.name: replace(topic, name=f"/{namespace}/{topic.name}") if namespace else topic
            for topic in topics
            if topic not in shared
        }
        for namespace in namespaces
    }
    bag = FlightBag(path, [*shared, *itertools.chain(*(own.values() for own in named.values()))])
    writers = [
        _Aircraft(bag, namespace, named[namespace], topics, 2.0 * k)
        for k, namespace in enumerate(namespaces)
    ]
    every = state_rate // command_rate
    for k in range(round(duration * state_rate) + 1):
        time = k / state_rate
        stamp, heard = start + round(time * 1e9), WALL + round(time * 1e9 / speed)
        for writer in writers:
            writer.state(time, stamp, heard)
            silent = any(begin <= time < end for begin, end in silence)
            if k % every == 0 and not silent:
                writer.command(time, stamp, heard + COMMAND_DELAY, mode_at(time, fallbacks)[0])
            if k % (state_rate // 5) == 0 and not silent:
                writer.views(time, stamp, heard + COMMAND_DELAY)
            if k % state_rate == 0:
                writer.reports(time, stamp, heard, fallbacks, silent)
    bag.close()


class _Aircraft:
    def __init__(self, bag, namespace, topics, held, turn):
        self._bag, self._namespace, self._topics = bag, namespace, topics
        self._held = {topic.name for topic in held}
        self._flight, self._random = SyntheticFlight(turn), np.random.default_rng(0)
        self._wire, self._errors = CommandWire(), tracking_message()
        self._truth = TARGET_TRUTH.type()
        self._changes, self._mode = 0, OPTIMAL

    def _write(self, topic, heard, message):
        if topic.name in self._held:
            data = message if isinstance(message, bytes) else serialize_message(message)
            self._bag.write(self._topics.get(topic.name, topic), heard, data)

    def state(self, time, stamp, heard):
        flight = self._flight
        vehicle, rates = flight.vehicle(time), (flight.turn_rate, 0.0, 0.0)
        set_truth(self._truth, stamp, flight.target(time), TARGET_VELOCITY)
        self._write(CLOCK, heard, filled_clock(stamp))
        self._write(TARGET_TRUTH, heard, self._truth)
        self._write(AIR_VELOCITY, heard, filled_air(stamp, vehicle[5]))
        odometry = filled_odometry(stamp, vehicle, rates, flight.ground_velocity(time))
        self._write(ODOMETRY, heard, odometry)

    def command(self, time, stamp, heard, mode):
        flight, number = self._flight, TRACKING["cost"].type()
        plan = flight.plan(time)
        inputs = self._random.normal(0.0, 1e-3, (STAGES, 3))
        inputs[:, 0] += flight.turn_rate
        path = PlannedPath(plan, np.tile(flight.ground_velocity(time), (STAGES + 1, 1)))
        self._write(COMMAND, heard, self._wire.write(stamp, inputs, STEP, path))
        orbit = orbit_about(flight.target(time), TARGET_VELOCITY, ORBIT_WANTED)
        self._write(ORBIT, heard, filled_orbit(stamp, orbit))
        set_stamp(self._errors.header.stamp, stamp)
        for k, name in enumerate(ERRORS):
            number.data = self._errors.position[k] = float(self._random.normal())
            self._write(TRACKING[name], heard, number)
        figures = [
            *self._errors.position[: len(ERRORS)],
            bank_from_turn_rate(flight.turn_rate, ORBIT_WANTED.speed),
            *flight.target(time),
            TARGET_STD,
            *WIND,
            MODES.index(FallbackMode(mode)),
        ]
        for k, figure in enumerate(figures):
            self._errors.position[k] = float(figure)
        self._write(TRACKING_ERRORS, heard, self._errors)
        number.data = 1.0 + time
        self._write(TRACKING["cost"], heard, number)
        number.data = 1e-3
        self._write(TRACKING["solve_time"], heard, number)

    def views(self, time, stamp, heard):
        plan, target = self._flight.plan(time), self._flight.target(time)
        self._write(PREDICTED_PATH, heard, path_message(stamp, plan))
        self._write(MARKERS, heard, markers_message(stamp, plan, target, ORBIT_WANTED))
        seen = target + self._random.normal(0.0, STD, 3)
        self._write(TARGET, heard, filled_point(stamp, seen))

    def reports(self, time, stamp, heard, fallbacks, silent):
        mode = mode_at(time, fallbacks)
        if mode != self._mode:
            self._mode, self._changes = mode, self._changes + 1
        values = {
            "mode": mode[0],
            "mode reason": mode[1],
            "mode changes": self._changes,
            **orbit_values(ORBIT_WANTED),
            **{f"figure {k} [m]": f"{self._random.normal():.6g}" for k in range(40)},
        }
        nodes = {"uav_simulator": {"speed": 1.0}, "target_publisher": {"began [ns]": 0}}
        if not silent:
            nodes["nmpc_controller"] = values
        level = DiagnosticStatus.OK if mode is OPTIMAL else DiagnosticStatus.WARN
        prefix = f"{self._namespace}/" if self._namespace else ""
        for node, figures in nodes.items():
            status = filled_status(stamp, f"{prefix}{node}", "fine", level, figures)
            self._write(DIAGNOSTICS, heard + DIAGNOSTIC_DELAY, status)


def rewritten(source, path, keep=lambda channel, message: True, **options):
    """The same messages as another recorder writes them.

    Args:
        source: File of a bag.
        path: File to write.
        keep: Which messages.
        options: Of the writer of the format's own library.
    """
    with source.open("rb") as read, path.open("wb") as written:
        writer = Writer(written, **options)
        writer.start(profile="ros2")
        ours = {}
        for schema, channel, message in make_reader(read).iter_messages():
            if not keep(channel, message):
                continue
            if channel.topic not in ours:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                ours[channel.topic] = writer.register_channel(channel.topic, "cdr", kind)
            number, log_time = ours[channel.topic], message.log_time
            writer.add_message(number, log_time, message.data, message.publish_time)
        writer.finish()
    return path


def lengthen(source, path, times):
    """Write a bag that repeats the flight of another one.

    Args:
        source: File of the other one.
        path: File to write.
        times: How often.
    """
    by_name = {f"/{topic.name.lstrip('/')}": topic for topic in ALL}
    with Reader(source) as reader:
        heard = [
            (by_name[connection.topic], time, data)
            for connection, time, data in reader.messages(reader.connections)
            if connection.topic in by_name  # the writer adds the transforms
        ]
    period = heard[-1][1] - heard[0][1] + 20_000_000
    bag = FlightBag(path)
    for number in range(times):
        for topic, time, data in heard:
            if topic is CLOCK or topic in STAMPED:
                seconds, rest = STAMP.unpack_from(data, STAMP_AT)
                stamp = divmod(seconds * SECOND + rest + number * period, SECOND)
                data = data[:STAMP_AT] + STAMP.pack(*stamp) + data[STAMP_AT + STAMP.size :]
            bag.write(topic, time + number * period, data)
    bag.close()
