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

"""A real node without an executor: messages go into its callbacks by hand."""

from __future__ import annotations

import dataclasses
import math
import time
import traceback
from unittest import mock

import rclpy
from fingerprint import PACKAGE, fingerprints
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.nodes.messages.conversions import measurement_from_odometry

FLOWN_BY = ("control", "estimation", "simulation")  # rooms whose objects a node flies by


def _listener(subscription):
    """Its callback, for messages, though it may ask for their bytes."""
    if not subscription.raw:
        return subscription.callback
    return lambda message: subscription.callback(serialize_message(message))


class NodeHarness:
    """A node to which nothing happens but what is done here.

    Exceptions come out of the calls: in flight they would end the process.

    Args:
        node_class: Of the node.
        parameters: Dataclass with the values of its parameters.
        refusals: From the node to how many messages it has refused so far.
        may_change: Attributes, however deep, that a refused message may change.
        more: Parameters besides.

    Attributes:
        published: Called with topic and message at every publish, before the node goes on.
        clock: What the node takes for steady time [s].
        first_error: Traceback of the first error in a callback.
    """

    def __init__(self, node_class, parameters, refusals, may_change, **more):
        harness = self

        class Tapped(node_class):
            """The node, with a listener on every publisher."""

            def create_publisher(self, kind, topic, *rest, **options):
                publisher = super().create_publisher(kind, topic, *rest, **options)
                publish = publisher.publish

                def tapped(message):
                    publish(message)  # what cannot be serialized raises here
                    if isinstance(message, bytes):
                        message = deserialize_message(message, kind)
                    harness.published(topic, message)

                publisher.publish, publisher.get_subscription_count = tapped, lambda: 1
                return publisher

        values = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        }
        overrides = [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            for name, value in {**values, **more}.items()
        ]
        self.published = lambda topic, message: None
        self.clock = 1000.0
        self.first_error = ""
        self._refusals, self._may_change = refusals, may_change
        self.node = Tapped(parameter_overrides=overrides)
        self._callbacks = {
            subscription.topic_name.lstrip("/"): _listener(subscription)
            for subscription in self.node.subscriptions
        }

    def deliver(self, topic, message):
        """Hand a message over; returns whether the node refused it.

        If it did, nothing that it flies by may have changed.
        """
        before, refused = self.held(), self._refusals(self.node)
        self.tell(topic, message)
        if self._refusals(self.node) == refused:
            return False
        after = self.held()
        changed = [name for name in before | after if before.get(name) != after.get(name)]
        assert not changed, f"{topic}: a refused message changed {', '.join(changed)}"
        return True

    def tell(self, topic, message):
        """Hand a message over."""
        self._call(self._callbacks[topic.lstrip("/")], message)

    def fire(self):
        """Let every timer be due."""
        for timer in self.node.timers:
            self._call(timer.callback)

    def now(self):
        """What the node takes for steady time [s]."""
        return self.clock

    def _call(self, callback, *arguments):
        try:
            with mock.patch.object(time, "monotonic", self.now):
                callback(*arguments)
        except Exception:
            self.first_error = self.first_error or traceback.format_exc()
            raise

    def restart(self):
        """A managed node forgets everything."""
        for transition in ("deactivate", "cleanup", "configure", "activate"):
            getattr(self.node, f"trigger_{transition}")()

    def held(self):
        """Digests of what the node flies by, by name."""
        rooms = tuple(f"{PACKAGE}.{room}." for room in FLOWN_BY)
        flown_by = {
            name: value
            for name, value in vars(self.node).items()
            if name not in self._may_change
            and (type(value).__module__.startswith(rooms) or isinstance(value, (bool, int, float)))
        }
        return fingerprints(flown_by, self._may_change)


def start_ros():
    """ROS in this process, silent: thousands of refused messages are thousands of warnings."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    rclpy.logging.set_logger_level("", rclpy.logging.LoggingSeverity.FATAL)


def vehicle_from_odometry(message):
    """State (x, y, z, psi, chi, v), shape (6,), of an Odometry message in still air."""
    measurement = measurement_from_odometry(message)
    return measurement.state(math.hypot(*measurement.ground_velocity))
