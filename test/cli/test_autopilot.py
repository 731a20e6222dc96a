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

"""The simulated autopilot from the command line."""

import os

import pytest
from processes import TERMINATE, ended, started
from pymavlink import mavutil

PORT = 20000 + os.getpid() % 20000 + 50


def test_it_flies_until_it_is_told_to_end():
    connection = mavutil.mavlink_connection(f"udpin:127.0.0.1:{PORT}")
    where = ["--connection", f"udpout:127.0.0.1:{PORT}", "--origin=-33.9,18.4,40", "--system", "7"]
    with started("cli.main", "autopilot", *where, "--dialect", "px4") as process:
        position = connection.recv_match(type="GLOBAL_POSITION_INT", blocking=True, timeout=60.0)
        connection.close()
        code, words = ended(process, TERMINATE)
    assert position.get_srcSystem() == 7
    assert position.lat == pytest.approx(-339000000, abs=1e5)
    assert code == 0
    assert words.startswith("px4: system 7, mode LOITER, at udpout:")
