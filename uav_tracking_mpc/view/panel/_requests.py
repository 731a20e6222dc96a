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

"""Requests of one aircraft: outside of the drawing thread, and one at a time."""

from __future__ import annotations

import logging
import threading
import time
import weakref
from collections.abc import Callable, Mapping
from typing import Any

from uav_tracking_mpc.view.steering import Steering

logger = logging.getLogger(__name__)

POLL_PERIOD = 1.0  # s of wall time between questions for a node's parameters


class Requests:
    """Asks one aircraft's steering, in threads of its own.

    Args:
        steering: What is asked.
    """

    def __init__(self, steering: Steering) -> None:
        self._steering, self._one_at_a_time = steering, threading.Lock()
        self._known: dict[str, dict[str, Any]] = {}
        self._polled: dict[str, float] = {}
        self._changes = 0

    def begin(
        self,
        request: Callable[[], str],
        answered: Callable[[str], None],
        failed: Callable[[str], None],
    ) -> None:
        """Make a request when those before it are answered.

        Args:
            request: Answers why it was refused, or nothing.
            answered: Takes that, in the thread of the request.
            failed: Takes what went wrong instead, in words.
        """

        def ask() -> None:
            try:
                with self._one_at_a_time:
                    refusal = request()
            except Exception as error:  # whatever it is, the page lives on
                logger.exception("a request of the page failed")
                failed(f"{type(error).__name__}: {error}")
            else:
                answered(refusal)

        threading.Thread(target=ask, daemon=True).start()

    def change(self, node: str, values: Mapping[str, Any]) -> str:
        """Change parameters; to be called by a request.

        Args:
            node: Whose.
            values: By name.

        Returns:
            Why it was refused; empty where it was done.
        """
        refusal = self._steering.change(node, **values)
        self._changes += 1  # what was asked for before may be of before
        if not refusal:
            self._known[node] = {**self._known.get(node, {}), **values}
        return refusal

    def parameters(self, node: str) -> Mapping[str, Any]:
        """Parameters as far as they are known, empty before the first answer; never waits.

        Args:
            node: Whose. About once a second it is asked again.
        """
        now = time.monotonic()
        if now >= self._polled.get(node, 0.0):
            self._polled[node] = float("inf")  # until it has answered
            threading.Thread(target=self._poll, args=(node,), daemon=True).start()
        return self._known.get(node, {})

    def _poll(self, node: str) -> None:
        changes = self._changes
        try:
            values = dict(self._steering.parameters(node))
            if values and changes == self._changes:
                self._known[node] = values
        except Exception as error:  # a node that is away: what was known stays
            logger.debug("parameters of %s: %s", node, error)
        finally:
            self._polled[node] = time.monotonic() + POLL_PERIOD


_of: weakref.WeakKeyDictionary[Steering, Requests] = weakref.WeakKeyDictionary()


def requests_of(steering: Steering) -> Requests:
    """The requests of an aircraft, the same for all parts of its panel.

    Args:
        steering: Of the aircraft.
    """
    return _of.setdefault(steering, Requests(steering))
