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

"""A flight to watch and to steer whose every answer is in the hands of a test."""

from __future__ import annotations

import threading

import numpy as np

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SIMULATOR,
    TARGET,
    FlightSource,
    NodeStatus,
    Sight,
    Steering,
    TargetSight,
    WatchedFlight,
)


def sight(time=10.0, **more):
    """A sight of ``small_uav`` on its way."""
    values = {
        "time": time,
        "position": np.array([275.0, 0.0, 121.0]),
        "heading": 1.5,
        "path_angle": 0.05,
        "bank": -0.2,
        "airspeed": 22.5,
        "ground_velocity": np.zeros(3),
        "target": TargetSight(np.zeros(3)),
        "mode": FallbackMode.OPTIMAL,
        "errors": {
            "range_error": 0.4,
            "bearing_error": 0.0,
            "altitude_error": 1.0,
            "pitch_error": 0.05,
            "speed_error": 0.5,
        },
        "cost": 2.5,
        "solve_time": 0.002,
        "latency": 0.004,
        "statuses": (NodeStatus(CONTROLLER, 0, "tracking: optimal plan", {"solves": "12"}),),
    }
    return Sight(**{**values, **more})


class StandInSteering(Steering):
    """Keeps what was asked, and answers as it is told.

    Attributes:
        asked: Requests in order, each a tuple of its name and its arguments.
        refusal: What the next requests are refused with.
        failure: Raised by the next requests.
        go_on: Requests wait for it.
        values: Parameters of each node.
    """

    def __init__(self, nodes=(CONTROLLER, SIMULATOR, TARGET)):
        configuration = load_configuration("small_uav")
        sections = {
            CONTROLLER: configuration.controller,
            SIMULATOR: configuration.simulator,
            TARGET: configuration.target,
        }
        self.nodes, self.comparable = frozenset(nodes), True
        self.values = {node: dict(vars(sections[node])) for node in nodes}
        self.faults = {"lose the target": "No target position arrives for 10 s."}
        self.asked, self.refusal, self.failure = [], "", None
        self.go_on = threading.Event()
        self.go_on.set()

    def parameters(self, node):
        return dict(self.values[node])

    def change(self, node, **values):
        refusal = self._answer("change", node, values)
        if not refusal:
            self.values[node] |= values
        return refusal

    def send_target(self, east, north):
        return self._answer("send_target", east, north)

    def pause(self, still):
        return self._answer("pause", still)

    def reset(self):
        return self._answer("reset")

    def engage(self, on):
        return self._answer("engage", on)

    def inject(self, fault):
        return self._answer("inject", fault)

    def compare(self, on):
        return self._answer("compare", on)

    def _answer(self, *asked):
        self.asked.append(asked)
        self.go_on.wait()
        if self.failure is not None:
            raise self.failure
        return self.refusal


class StandInFlight(WatchedFlight):
    """Shows what it is given."""

    def __init__(self, name="aircraft", steering=None):
        self.name, self.steering = name, steering
        self.seen = [sight()]

    @property
    def sight(self):
        return self.seen[-1]

    @property
    def tracking(self):
        return load_configuration("small_uav").controller

    def past(self, span):
        return [seen for seen in self.seen if seen.time >= self.seen[-1].time - span]


class StandInSource(FlightSource):
    """Aircraft that a test adds."""

    def __init__(self, *flights):
        self.aircraft = list(flights)

    def flights(self):
        return self.aircraft

    def close(self):
        pass


class StandInClient:
    """A browser, as far as requests know it."""

    def __init__(self):
        self.notifications = []

    def add_notification(self, title, body, **_):
        self.notifications.append((title, body))
