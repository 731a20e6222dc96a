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

"""Nodes in the process of a test: spun together, or one by hand without an executor."""

from __future__ import annotations

import contextlib
import math
import os
import time
import traceback
from dataclasses import asdict
from unittest import mock

import rclpy
from fingerprint import PACKAGE, fingerprints
from processes import PATIENCE, TERMINATE, spin
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.nodes.messages.conversions import measurement_from_odometry

FLOWN_BY = ("control", "estimation", "simulation")  # rooms whose objects a node flies by


def overrides(parameters):
    """Parameters of a node by name, as rclpy takes them."""
    return [
        Parameter(name, value=list(value) if isinstance(value, tuple) else value)
        for name, value in parameters.items()
    ]


def ending(node):
    """A node that is up, and is ended as by a signal as soon as it is spun."""
    os.kill(os.getpid(), TERMINATE)
    return node


def tapped(node_class, heard):
    """A kind of node that thinks somebody listens, and hands over what it has published.

    Args:
        node_class: Of the node.
        heard: Called with the name of the topic and the message, before the node goes on.
    """

    class Tapped(node_class):
        """The node, with a listener on every publisher."""

        def create_publisher(self, kind, topic, *rest, **options):
            publisher = super().create_publisher(kind, topic, *rest, **options)
            publish = publisher.publish

            def told(message):
                publish(message)  # what cannot be serialized raises here
                data = message if isinstance(message, bytes) else serialize_message(message)
                heard(topic, deserialize_message(data, kind))

            publisher.publish, publisher.get_subscription_count = told, lambda: 1
            return publisher

    return Tapped


def callback(node, topic):
    """What a node does with a message of a topic, though it may ask for its bytes."""
    (subscription,) = [s for s in node.subscriptions if s.topic_name.strip("/") == topic.strip("/")]
    if not subscription.raw:
        return subscription.callback
    return lambda message: subscription.callback(serialize_message(message))


class Nodes:
    """Nodes of one context, spun by one executor; they go as it ends."""

    def __init__(self, executor=SingleThreadedExecutor, **options):
        self.context = rclpy.Context()
        self.context.init(args=[], **options)
        self.executor = executor(context=self.context)
        self.made = []

    def add(self, node_class, cli_args=(), namespace="", **parameters):
        """A node with parameters."""
        return self.join(
            node_class(
                context=self.context,
                cli_args=[*cli_args],
                namespace=namespace,
                parameter_overrides=overrides(parameters),
            )
        )

    def peer(self, name):
        """A node without anything."""
        return self.join(rclpy.create_node(name, context=self.context))

    def join(self, node):
        """Spin a node with the others."""
        self.made.append(node)
        self.executor.add_node(node)
        return node

    def remove(self, node):
        """A node goes before the others."""
        self.made.remove(node)
        self.executor.remove_node(node)
        node.destroy_node()

    def listen(self, *topics, by=None):
        """Messages that come from now on, to a node if it is named, by name of the topic."""
        node, heard = by or self.peer("listener"), {topic.name: [] for topic in topics}
        for topic in topics:
            node.create_subscription(topic.type, topic.name, heard[topic.name].append, 100)
        return heard

    def send(self, messages, period=0.05, qos=None):
        """Publish again and again what a function gives, by topic; the publishers by topic."""
        node, publishers = self.peer("sender"), {}

        def send():
            for topic, message in messages().items():
                if topic not in publishers:
                    publishers[topic] = node.create_publisher(
                        topic.type, topic.name, qos or topic.qos
                    )
                publishers[topic].publish(message)

        node.create_timer(period, send)
        return publishers

    def spin(self, until, limit=PATIENCE, also=lambda: None):
        """Whether a condition comes to hold while the nodes are spun."""
        return spin(self.executor, until, limit, also)

    def end(self):
        for node in self.made:
            getattr(node, "finish", lambda: None)()
            node.destroy_node()
        self.executor.shutdown()
        self.context.try_shutdown()


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
        self.published = lambda topic, message: None
        self.clock = 1000.0
        self.first_error = ""
        self._refusals, self._may_change = refusals, may_change
        kind = tapped(node_class, lambda topic, message: self.published(topic, message))
        self.node = kind(parameter_overrides=overrides({**asdict(parameters), **more}))

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
        self._call(callback(self.node, topic), message)

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


@contextlib.contextmanager
def silent_ros():
    """ROS in this process, silent: thousands of refused messages are thousands of warnings."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    rclpy.logging.set_logger_level("", rclpy.logging.LoggingSeverity.FATAL)
    yield
    rclpy.try_shutdown()
    rclpy.logging.set_logger_level("", rclpy.logging.LoggingSeverity.INFO)


def vehicle_from_odometry(message):
    """State (x, y, z, psi, chi, v), shape (6,), of an Odometry message in still air."""
    measurement = measurement_from_odometry(message)
    return measurement.state(math.hypot(*measurement.ground_velocity))
