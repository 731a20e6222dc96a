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

"""Simulated autopilots without a wire, stepped as quickly as the machine can."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.autopilot.arduplane import ArduPlane
from uav_tracking_mpc.autopilot.autopilot_core import AttitudeTarget
from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.px4 import Px4
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.settings.configuration import load_configuration

ORIGIN = LocalFrame(math.radians(47.3977), math.radians(8.5456), 488.0)
ROLL_ALONE = 0b11111110
BOTH = pytest.mark.parametrize("dialect", [ArduPlane, Px4])


def autopilot(dialect, *overrides, on_runway=False):
    configuration = load_configuration("small_uav", overrides)
    return dialect(configuration, ORIGIN, on_runway)


def fly(core, seconds, each_tick=None):
    """States after every tick."""
    states = []
    for _ in range(round(seconds / TICK)):
        if each_tick is not None:
            each_tick()
        core.step()
        states.append(core.state)
    return states


def bank(degrees, mask=ROLL_ALONE, pitch=0.0, thrust=0.0):
    return AttitudeTarget(mask, math.radians(degrees), pitch, thrust)


def banks(states):
    """In degrees."""
    return np.degrees([state.roll for state in states])


def off_circle(states, radius, east=0.0, north=0.0):
    """Greatest distance in metres from a circle."""
    distances = [math.hypot(state.east - east, state.north - north) for state in states]
    return np.max(np.abs(np.array(distances) - radius))


def position_of(message):
    """Point in ``map`` of a GLOBAL_POSITION_INT."""
    latitude, longitude = math.radians(message.lat * 1e-7), math.radians(message.lon * 1e-7)
    return ORIGIN.position(latitude, longitude, message.alt * 1e-3)


def place(east, north):
    """Latitude and longitude in degrees of a point in ``map``."""
    latitude, longitude, _ = ORIGIN.place([east, north, 0.0])
    return math.degrees(latitude), math.degrees(longitude)
