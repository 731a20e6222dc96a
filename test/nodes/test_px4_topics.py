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

"""Without px4_msgs, or with old ones, PX4's topics are refused in one line."""

import sys
from types import ModuleType

import pytest

from uav_tracking_mpc.links import LinkRefusedError
from uav_tracking_mpc.nodes.px4_topics import HEARD, SAID, RosWire


def test_without_px4_msgs_it_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "px4_msgs.msg", None)
    with pytest.raises(LinkRefusedError, match="needs px4_msgs"):
        RosWire()


def test_messages_of_an_older_px4_are_refused_by_name(monkeypatch):
    old = ModuleType("px4_msgs.msg")
    for name in (*HEARD, *SAID):
        if not name.startswith("FixedWing"):
            setattr(old, name, object)
    monkeypatch.setitem(sys.modules, "px4_msgs", ModuleType("px4_msgs"))
    monkeypatch.setitem(sys.modules, "px4_msgs.msg", old)
    with pytest.raises(LinkRefusedError, match="no FixedWingLateralSetpoint.*1.17"):
        RosWire()
