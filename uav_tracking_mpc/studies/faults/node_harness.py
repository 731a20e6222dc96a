"""A real node on a bench: messages go into its callbacks by hand, what it publishes is seen."""

from __future__ import annotations

import dataclasses
import traceback
from collections import Counter
from collections.abc import Callable, Collection
from typing import Any

import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.studies.faults.fingerprint import fingerprint
from uav_tracking_mpc.studies.faults.invariants import Violation

KEPT = 20  # examples of each kind of finding


@dataclasses.dataclass
class Findings:
    """What came of the messages.

    Attributes:
        messages: Delivered, by topic.
        refused: Of them, by topic.
        exceptions: Out of a callback.
        violations: By invariant.
        examples: The first of each, in words.
    """

    messages: Counter[str] = dataclasses.field(default_factory=Counter)
    refused: Counter[str] = dataclasses.field(default_factory=Counter)
    exceptions: int = 0
    violations: Counter[str] = dataclasses.field(default_factory=Counter)
    examples: list[str] = dataclasses.field(default_factory=list)

    def violation(self, found: Violation) -> None:
        """Count it."""
        self.violations[found.invariant] += 1
        if self.violations[found.invariant] <= KEPT:
            self.examples.append(f"{found.invariant}: {found.detail}")

    def exception(self, topic: str, error: Exception) -> None:
        """Count it."""
        self.exceptions += 1
        if self.exceptions <= KEPT:
            lines = traceback.format_exception(error)
            self.examples.append(f"{topic}: {''.join(lines)}")


class Bench:
    """A node without an executor: nothing happens to it but what is done here.

    Args:
        node_class: Of the node.
        parameters: Dataclass with the values of its parameters.
        published: Called with topic and message at every publish, before the node goes on.
        roots: Attributes of the node that hold what it goes by.
        leaving_out: Attributes further down that a refused message may change.
        refusals: How many messages the node has refused so far.
        findings: Where to write down what went wrong.
        more: Parameters besides.
    """

    def __init__(
        self,
        node_class: Any,
        parameters: Any,
        published: Callable[[str, Any], None],
        *,
        roots: Collection[str],
        leaving_out: Collection[str],
        refusals: Callable[[Any], int],
        findings: Findings,
        more: dict[str, Any],
    ) -> None:
        class Tapped(node_class):  # type: ignore[misc]
            """The node, with somebody who listens to every publisher."""

            def create_publisher(self, kind: Any, topic: str, *rest: Any, **options: Any) -> Any:
                publisher = super().create_publisher(kind, topic, *rest, **options)
                publish = publisher.publish

                def tapped(message: Any) -> None:
                    publish(message)  # what cannot be serialized raises here
                    if isinstance(message, bytes):
                        message = deserialize_message(message, kind)
                    published(topic, message)

                publisher.publish, publisher.get_subscription_count = tapped, lambda: 1
                return publisher

        values = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        } | more
        overrides = [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            for name, value in values.items()
        ]
        self.node = Tapped(parameter_overrides=overrides)
        self._roots, self._leaving_out = roots, leaving_out
        self._refusals, self._findings = refusals, findings
        self._callbacks = {
            subscription.topic_name.lstrip("/"): subscription.callback
            for subscription in self.node.subscriptions
        }
        self._timers = {timer.callback.__name__: timer.callback for timer in self.node.timers}

    def deliver(self, topic: str, message: Any, right: bool = False) -> None:
        """Hand a message over; if the node refuses it, nothing else may have changed.

        Args:
            topic: Its name.
            message: Right or wrong.
            right: Whether it is as it should be: then this is not looked at, which takes its time.
        """
        before, refused = b"" if right else self._held(), self._refusals(self.node)
        self._findings.messages[topic] += 1
        self._call(topic, self._callbacks[topic], message)
        if self._refusals(self.node) > refused:
            self._findings.refused[topic] += 1
            if not right and self._held() != before:
                words = f"{topic}: a refused message changed what the node holds: {message}"
                self._findings.violation(Violation("half applied", words))

    def tell(self, topic: str, message: Any) -> None:
        """Hand over a message that is right, such as the time."""
        self._call(topic, self._callbacks[topic], message)

    def fire(self, timer: str) -> None:
        """Let the timer with this callback be due."""
        self._call(timer, self._timers[timer])

    def close(self) -> None:
        """Destroy the node."""
        self.node.destroy_node()

    def _call(self, name: str, callback: Callable[..., None], *arguments: Any) -> None:
        try:
            callback(*arguments)
        except Exception as error:  # in flight it would end the process
            self._findings.exception(name, error)

    def _held(self) -> bytes:
        return fingerprint([getattr(self.node, name) for name in self._roots], self._leaving_out)


def quiet() -> None:
    """A million refused messages are a million warnings: let them pass unsaid."""
    rclpy.logging.set_logger_level("", rclpy.logging.LoggingSeverity.FATAL)
