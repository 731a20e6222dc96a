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

import math

import pytest
from autopilot_steps import ORIGIN

from uav_tracking_mpc.autopilot.ground_vehicle import GroundVehicle
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.settings.target import TargetParameters


def test_it_tells_where_it_drives():
    target = TargetParameters(motion="line", position=(50.0, -20.0, 0.0), speed=5.0)
    vehicle, parser, heard = GroundVehicle(target, ORIGIN, 42), mavlink.MAVLink(None), []
    for tick in range(1000):
        for frame in vehicle.frames(0.01 * tick):
            heard += parser.parse_buffer(frame)
    assert {message.get_srcSystem() for message in heard} == {42}
    positions = [m for m in heard if m.get_type() == "GLOBAL_POSITION_INT"]
    assert len(positions) == 50
    last = positions[-1]
    place = ORIGIN.position(
        math.radians(last.lat * 1e-7), math.radians(last.lon * 1e-7), last.alt * 1e-3
    )
    east, north, _ = place
    driven = 5.0 * last.time_boot_ms * 1e-3
    assert math.hypot(east - 50.0, north + 20.0) == pytest.approx(driven, abs=0.05)
    assert math.hypot(last.vx, last.vy) == pytest.approx(500.0, abs=1.0)
