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
