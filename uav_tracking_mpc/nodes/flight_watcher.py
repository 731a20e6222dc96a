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

"""Listens to every aircraft of a domain as it appears, for who only looks."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_parameter_events

from uav_tracking_mpc.nodes.heard_aircraft import HeardAircraft
from uav_tracking_mpc.nodes.overhearing import Overhearing
from uav_tracking_mpc.nodes.remote_parameters import RemoteParameters
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY
from uav_tracking_mpc.settings.tracking import TrackingParameters

CONTROLLER = "nmpc_controller"
LOOK_PERIOD = 0.5  # s between looks for aircraft
QUEUE = 50  # reports that may wait: several aircraft send them on one topic
EVENTS = "/parameter_events"


class FlightWatcher(Node):
    """Keeps what each aircraft, its controller and its target said last.

    An aircraft is wherever somebody publishes ``uav/odometry``; it stays when it falls silent.

    Args:
        options: Of rclpy's Node.

    Attributes:
        aircraft: By namespace, absolute.
        parameters: Of their controllers, by namespace.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("flight_watcher", start_parameter_services=False, **options)
        # Another thread looks: both are replaced, never changed.
        self.aircraft: dict[str, HeardAircraft] = {}
        self.parameters: dict[str, RemoteParameters[TrackingParameters]] = {}
        Overhearing(self, DIAGNOSTICS, self._on_diagnostics, QUEUE)
        self.create_subscription(
            ParameterEvent, EVENTS, self._on_change, qos_profile_parameter_events
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(LOOK_PERIOD, self._look, clock=steady)

    def _look(self) -> None:
        """Listen to aircraft that are new, and ask controllers that have changed."""
        suffix = f"/{ODOMETRY.name}"
        for topic, _ in self.get_topic_names_and_types():
            namespace = topic.removesuffix(suffix) or "/"
            known = namespace in self.aircraft or not topic.endswith(suffix)
            if not known and self.count_publishers(topic):
                self._listen(namespace)
        for parameters in self.parameters.values():
            parameters.follow()

    def _listen(self, namespace: str) -> None:
        controller = f"{namespace.rstrip('/')}/{CONTROLLER}"
        asked = RemoteParameters(self, controller, TrackingParameters)
        self.parameters = {**self.parameters, namespace: asked}
        self.aircraft = {**self.aircraft, namespace: HeardAircraft(self, namespace)}

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            path = f"/{status.name.partition(':')[0]}"
            if (heard := self._whose(path)) is not None:
                heard.report(status)

    def _whose(self, path: str) -> HeardAircraft | None:
        """The aircraft to which a node belongs: that of the longest namespace it is in."""
        namespace = path
        while namespace:
            namespace = namespace.rpartition("/")[0]
            if (heard := self.aircraft.get(namespace or "/")) is not None:
                return heard
        return None

    def _on_change(self, event: ParameterEvent) -> None:
        for parameters in self.parameters.values():
            if parameters.remote == event.node:
                parameters.change()
