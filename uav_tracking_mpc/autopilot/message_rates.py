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

"""Which messages are due, each at a rate of its own."""

from __future__ import annotations

from collections.abc import Mapping

ROUNDING = 1e-6  # s


class MessageRates:
    """Intervals of messages by name.

    Args:
        rates: How often each is sent where nobody asks otherwise, in [Hz].
    """

    def __init__(self, rates: Mapping[str, float]) -> None:
        self._usual = {name: 1.0 / rate for name, rate in rates.items()}
        self._intervals = dict(self._usual)
        self._due: dict[str, float] = dict.fromkeys(self._intervals, 0.0)

    def ask(self, name: str, interval: float) -> None:
        """MAV_CMD_SET_MESSAGE_INTERVAL.

        Args:
            name: Of the message.
            interval: In [s]; 0 for the usual one, negative for never.
        """
        if interval == 0.0:
            interval = self._usual.get(name, -1.0)
        if interval < 0.0:
            self._intervals.pop(name, None)
            return
        self._intervals[name] = interval
        self._due[name] = 0.0

    def due(self, now: float) -> list[str]:
        """Names of the messages that are due, which then count as sent.

        Args:
            now: Time since the start in [s].
        """
        found = []
        for name, interval in self._intervals.items():
            if now + ROUNDING < self._due[name]:
                continue
            found.append(name)
            late = now - self._due[name]
            # On a grid of the interval, so that the mean rate is what was asked for.
            self._due[name] = now + interval - (late if late < interval else 0.0)
        return found
