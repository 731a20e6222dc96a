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

"""An aircraft as it is heard, without ROS."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.heard_aircraft import Plan, Report
from uav_tracking_mpc.nodes.reported_orbit import orbit_values

NOW = 1000.0
ORBIT = Orbit(300.0, 120.0, 22.0, COUNTER_CLOCKWISE)
STATE = Measurement(
    50.0, np.array([1.0, 2.0, 3.0]), np.array([20.0, 4.0, 0.0]), 0.0, 0.0, -0.2, 0.0
)
FIGURES = {
    "range_error": 5.0, "bearing_error": 0.1, "altitude_error": -1.0, "pitch_error": 0.0,
    "speed_error": 0.2, "target_east": 10.0, "target_north": 20.0, "target_up": 1.0,
    "target_std": 0.4, "wind_east": 3.0, "wind_north": -4.0, "wind_up": 0.0, "mode": 0.0,
}  # fmt: skip


def said(value, age=0.0):
    """A message that came some seconds ago."""
    return SimpleNamespace(value=value, arrival=NOW - age, trouble="")


def nothing():
    """A topic on which nothing has come."""
    return SimpleNamespace(value=None, arrival=-math.inf, trouble="")


def report(age=0.0, node="nmpc_controller", words="fine", **values):
    """What a node said of itself some seconds ago."""
    values = {key: str(value) for key, value in values.items()}
    return Report(node, 1, words, {**orbit_values(ORBIT), **values}, NOW - age)


def aircraft(*reports, **messages):
    """An aircraft that flies, of which these messages differ."""
    plan = Plan(49.85, np.arange(15.0).reshape(5, 3), 0.1 * np.arange(5))
    orbit = FlownOrbit(np.array([10.0, 20.0, 120.0]), np.array([1.0, -2.0, 0.0]), 275.0, 22.0)
    values = {
        "state": said(STATE), "airspeed": said(17.0), "sighting": said(np.array([9.0, 19.0, 0.0])),
        "tracked": nothing(), "truth": said(np.array([10.5, 20.5, 1.0])), "plan": said(plan),
        "orbit": said(orbit), "figures": said(FIGURES), "cost": said(7.0), "solve_time": said(1e-3),
    }  # fmt: skip
    reports = {each.node: each for each in reports}
    return SimpleNamespace(**{**values, **messages}, reports=reports)
