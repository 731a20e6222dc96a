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

"""Limit cycles are told once, in words, with the likely cause."""

import math

import pytest

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.oscillation import OscillationReport
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.estimation.channel_response import ChannelResponse

AIRSPEED = 22.0
UNKNOWN = [ChannelResponse()] * 3
KNOWN = [ChannelResponse(lag=0.3, dead_time=0.2, trusted=True)] * 3


def told(channels, delays, axis=0, quiet=10.0):
    """Events of a swing by 20 deg of bank, or as much across the path, in 2 s."""
    events = EventLog()
    report = OscillationReport(events)
    rate = GRAVITY / AIRSPEED * math.tan(math.radians(20.0))
    during = ""
    for tick in range(round((20.0 + quiet) / 0.05)):
        time = 0.05 * tick
        inputs = [0.0, 0.0]
        inputs[axis] = rate * math.sin(math.pi * time) if time < 20.0 else 0.0
        report.see(time, tuple(inputs), AIRSPEED, channels, delays)
        during = report.words(axis) if time < 20.0 else during
    return events.take(), during, report


def test_period_amplitude_and_end_are_told():
    (begin, end), during, report = told(UNKNOWN, [0.5] * 3)
    assert begin.level is Level.WARNING
    assert begin.words.startswith(
        "limit cycle of the turn rate: +-20 deg of bank with a period of 2.0 s"
    )
    assert "+-20 deg of bank" in during
    assert end == (Level.INFO, "the limit cycle of the turn rate has ended")
    assert report.words(0) == report.words(1) == "none"


@pytest.mark.parametrize(
    ("channels", "delays", "cause"),
    [
        (UNKNOWN, [0.1] * 3, "is not what was told"),
        (KNOWN, [0.1] * 3, "together 0.50 s, not 0.10 s"),
        (KNOWN, [0.5] * 3, "weights of the inputs are too small"),
    ],
)
def test_the_cause_is_what_is_known_of_the_response(channels, delays, cause):
    (begin, *_), during, _ = told(channels, delays, quiet=0.0)
    assert cause in begin.words
    assert cause in during


def test_the_path_is_watched_as_well():
    (begin, *_), _, _ = told(UNKNOWN, [0.1] * 3, axis=1)
    assert begin.words.startswith("limit cycle of the path-angle rate: +-0.36 g")
