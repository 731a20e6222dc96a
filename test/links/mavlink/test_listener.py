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

"""What an autopilot says of itself."""

from types import SimpleNamespace

import pytest

from uav_tracking_mpc.links.mavlink.listener import Listener


@pytest.mark.parametrize(
    ("version", "identity"),
    [
        (None, "MAVLink system 3"),
        (SimpleNamespace(uid=0, uid2=[0] * 18), "MAVLink system 3"),
        (SimpleNamespace(uid=0x1234, uid2=[0] * 18), "0000000000001234"),
        (SimpleNamespace(uid=0x1234, uid2=[1, 255] + [0] * 16), "01ff" + "00" * 16),
    ],
)
def test_its_serial_number_tells_it_apart_or_else_its_number_on_mavlink(version, identity):
    autopilot = SimpleNamespace(version=version, system=3)
    assert Listener.identity.fget(autopilot) == identity
