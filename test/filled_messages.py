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

"""Messages as their senders fill them."""

from __future__ import annotations

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.flight_recorder import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import (
    set_air_velocity,
    set_command,
    set_measurement,
    set_odometry,
    set_point,
    set_stamp,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_message, set_orbit
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ODOMETRY,
    TARGET,
    TRACKING_ERRORS,
)

SECOND = 1_000_000_000  # ns


def filled_odometry(stamp, state, rates=(0.0, 0.0, 0.0), ground=None, **frames):
    """Of (x, y, z, psi, chi, v) and the rates that are flown, in still air unless told."""
    message = ODOMETRY.type()
    set_odometry(message, stamp, np.array(state), np.array(rates), ground, **frames)
    return message


def filled_measurement(stamp, seen):
    """Odometry of a measurement, with its bank and its noise."""
    message = ODOMETRY.type()
    set_measurement(message, stamp, seen)
    return message


def filled_air(stamp, speed, **frames):
    """An airspeed."""
    message = AIR_VELOCITY.type()
    set_air_velocity(message, stamp, speed, **frames)
    return message


def filled_point(stamp, place=(0.0, 0.0, 0.0), **frames):
    """Where a target is, or is to go."""
    message = TARGET.type()
    set_point(message, stamp, np.array(place), **frames)
    return message


def filled_command(stamp, plan, step=1.0, **frames):
    """Inputs of shape (n, 3)."""
    message = COMMAND.type()
    set_command(message, stamp, np.array(plan), step, **frames)
    return message


def filled_orbit(stamp, orbit):
    """The orbit that a command leads to."""
    message = orbit_message()
    set_orbit(message, stamp, orbit)
    return message


def filled_tracking(stamp, **figures):
    """Some of what the controller tracks by."""
    message = TRACKING_ERRORS.type(name=list(figures), position=list(figures.values()))
    set_stamp(message.header.stamp, stamp)
    return message


def filled_clock(stamp):
    """Simulated time."""
    message = CLOCK.type()
    set_stamp(message.clock, stamp)
    return message


def filled_status(stamp, node, words="", level=b"\x00", values=None):
    """What a node says of itself, and its values by name."""
    entries = [KeyValue(key=key, value=str(value)) for key, value in (values or {}).items()]
    status = DiagnosticStatus(level=level, name=f"{node}: status", message=words, values=entries)
    message = DiagnosticArray(status=[status])
    set_stamp(message.header.stamp, stamp)
    return message


def altered(message, path, value):
    """With another value at a path of fields and indices, as ``points.0.velocities``."""
    *parents, name = path.split(".")
    part = message
    for parent in parents:
        part = part[int(parent)] if parent.isdigit() else getattr(part, parent)
    if name.isdigit():
        part[int(name)] = value
    else:
        setattr(part, name, value)
    return message


def over_the_wire(message):
    """As it arrives."""
    return deserialize_message(serialize_message(message), type(message))


def write_messages(path, messages, **options):
    """A bag of (topic, when it was heard in [ns], message)."""
    bag = FlightBag(path, **options)
    for topic, heard, message in messages:
        bag.write(topic, heard, serialize_message(message))
    bag.close()
    return path


def sensed(stamp, state, place=(0.0, 0.0, 0.0), rates=(0.0, 0.0, 0.0)):
    """What a controller is sent of one instant: of target, air and state, by topic."""
    return {
        TARGET: filled_point(stamp, place),
        AIR_VELOCITY: filled_air(stamp, float(state[5])),
        ODOMETRY: filled_odometry(stamp, state, rates),
    }


def circling(time):
    """State and rates of who flies the orbit of ``small_uav`` about the origin, in [s]."""
    rate = 22.0 / 300.0
    turn = rate * time
    state = [300.0 * np.cos(turn), 300.0 * np.sin(turn), 120.0, turn + np.pi / 2.0, 0.0, 22.0]
    return state, [rate, 0.0, 0.0]
