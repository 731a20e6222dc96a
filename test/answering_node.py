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

"""A node on which requests are made without ROS: its services answer as a test says."""

from types import SimpleNamespace

from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message


class Client:
    """Of one service."""

    def __init__(self, kind, service, node):
        self.srv_type, self.service, self._node = kind, service, node

    def service_is_ready(self):
        return self.service in self._node.answers

    def call(self, request, timeout_sec):
        assert 0.0 < timeout_sec < 10.0
        self._node.asked.append(self.service)
        return self._node.answers[self.service](request)


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

    def create_client(self, kind, service):
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

    def fall_silent(self, owner):
        """Be known, as a killed node is for some seconds, and answer no more."""
        for service in self.answers:
            if service.startswith(f"{self.namespace}/{owner}/"):
                self.answers[service] = lambda request: None
