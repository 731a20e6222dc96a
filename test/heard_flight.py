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

"""Nodes and an aircraft without ROS: services answer and topics are heard as a test says."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rclpy.task import Future

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, FlownOrbit, Orbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.diagnostic_values import orbit_values
from uav_tracking_mpc.nodes.messages.heard_values import NodeReport
from uav_tracking_mpc.nodes.watching import Plan


class Client:
    """Of one service."""

    def __init__(self, kind, service, node):
        self.srv_type, self.service, self._node = kind, service, node

    def service_is_ready(self):
        return self.service in self._node.answers

    def call_async(self, request):
        self._node.asked.append(self.service)
        answer = Future()
        answer.set_result(self._node.answers[self.service](request))
        return answer


class AnsweringNode:
    """As much of rclpy's Node as requests use.

    Args:
        namespace: Of the nodes that answer, with a slash before it; empty for none.

    Attributes:
        answers: From the full name of a service to a function from request to response; None as a
            response is a request that nobody answers. A service that is not there is not offered.
        published: Topic and message, as they came.
        heard: Callbacks by topic.
        asked: Services that were called.
    """

    def __init__(self, namespace=""):
        self.namespace, self.answers, self.published, self.heard = namespace, {}, [], {}
        self.asked = []

    def create_client(self, kind, service, **options):
        return Client(kind, service, self)

    def create_publisher(self, kind, topic, qos):
        return SimpleNamespace(publish=lambda message: self.published.append((topic, message)))

    def create_subscription(self, kind, topic, callback, qos, raw=False):
        def heard(message):
            callback(serialize_message(message) if raw else message)

        self.heard[topic] = heard

    def offer(self, service, answer):
        """Answer a service of the namespace."""
        self.answers[f"{self.namespace}/{service}"] = answer

    def own(self, owner, values, refuse=lambda wanted: ""):
        """Be a node with parameters.

        Args:
            owner: Name of the node.
            values: Its parameters, changed in place.
            refuse: From wanted values by name to the reason why not, "" if they are taken.
        """

        def change(request):
            wanted = {}
            for message in request.parameters:
                parameter = Parameter.from_parameter_msg(message)
                value = parameter.value
                wanted[parameter.name] = list(value) if hasattr(value, "tolist") else value
            reason = refuse(wanted)
            if not reason:
                values.update(wanted)
            return SimpleNamespace(result=SimpleNamespace(successful=not reason, reason=reason))

        def listed(request):
            return SimpleNamespace(result=SimpleNamespace(names=list(values)))

        def got(request):
            return SimpleNamespace(
                values=[
                    Parameter(name, value=values[name]).to_parameter_msg().value
                    for name in request.names
                ]
            )

        self.offer(f"{owner}/list_parameters", listed)
        self.offer(f"{owner}/get_parameters", got)
        self.offer(f"{owner}/set_parameters_atomically", change)
        for name in ("set_parameters", "get_parameter_types", "describe_parameters"):
            self.offer(f"{owner}/{name}", lambda request: None)  # there, and not asked for

    def fall_silent(self, owner):
        """Be known, as a killed node is for some seconds, and answer no more."""
        for service in self.answers:
            if service.startswith(f"{self.namespace}/{owner}/"):
                self.answers[service] = lambda request: None


NOW = 1000.0
ORBIT = Orbit(300.0, 120.0, 22.0, COUNTER_CLOCKWISE)
STATE = Measurement(
    50.0, np.array([1.0, 2.0, 3.0]), np.array([20.0, 4.0, 0.0]), 0.0, 0.0, -0.2, 0.0
)
FIGURES = {
    "range_error": 5.0, "bearing_error": 0.1, "altitude_error": -1.0, "pitch_error": 0.0,
    "speed_error": 0.2, "target_east": 10.0, "target_north": 20.0, "target_up": 1.0,
    "target_std": 0.4, "wind_east": 3.0, "wind_north": -4.0, "wind_up": 0.0, "mode": 0.0,
    "stamp": STATE.stamp,
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
    return NodeReport("", node, 1, words, {**orbit_values(ORBIT), **values}, NOW - age)


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
