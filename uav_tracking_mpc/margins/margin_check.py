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

"""Whether the margins of the closed loop are as large as the parameters ask, in words.

It takes some tenths of a second and belongs where nothing waits for a command: where a flight is
configured, and after a change in flight in a thread of its own (:class:`MarginWatch`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from uav_tracking_mpc.control.latest_job import LatestJob
from uav_tracking_mpc.margins.loop_margins import CHANNELS, UNSTABLE, LoopMargins
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop
from uav_tracking_mpc.settings.tracking import TrackingParameters


def margin_warning(parameters: TrackingParameters) -> str:
    """What is to be said about the margins in still air; empty where they are large enough.

    Args:
        parameters: What is flown.
    """
    return _warning(parameters, None)[1]


def shortfalls(margins: LoopMargins, parameters: TrackingParameters) -> list[str]:
    """Which margins of what is commanded are smaller than the parameters ask, in words.

    Args:
        margins: Of the loop.
        parameters: ``delay_margin_min`` and ``gain_margin_min``, and what is commanded.
    """
    wanted_s, wanted_db = parameters.delay_margin_min, parameters.gain_margin_min
    found = []
    for name in CHANNELS[: parameters.vehicle.commanded]:
        channel = margins.channels[name]
        delay, gain = channel.delay_s, channel.gain_db
        if delay < wanted_s:
            found.append(f"{name} bears {delay:.2f} s of delay, delay_margin_min is {wanted_s:g} s")
        if gain < wanted_db:
            found.append(f"{name} bears {gain:.1f} dB of gain, gain_margin_min is {wanted_db:g} dB")
    return found


class MarginWatch(LatestJob[TrackingParameters]):
    """Judges the margins of the parameters that are asked for, in a thread of its own.

    Fixed parameters are those of the first call.

    Args:
        report: Called in that thread with a warning in words.
        patience: How long the first judgement waits in [s], so that it takes no time from the start
            of a flight.
        rest: How long nothing else may be asked for before a judgement begins in [s], so that a
            series of changes is judged once and takes no time from the commands meanwhile.
    """

    def __init__(
        self, report: Callable[[str], None], patience: float = 0.0, rest: float = 0.0
    ) -> None:
        super().__init__("margins", self._judge, patience, rest)
        self._report = report
        self._loop: OrbitLoop | None = None

    def _judge(self, parameters: TrackingParameters) -> None:
        self._loop, words = _warning(parameters, self._loop)
        if words:
            self._report(words)


def _warning(
    parameters: TrackingParameters, loop: OrbitLoop | None
) -> tuple[OrbitLoop | None, str]:
    """The loop of parameters, made from another one where there is one, and the words."""
    if parameters.delay_margin_min == 0.0 and parameters.gain_margin_min == 0.0:
        return loop, ""
    try:
        if loop is None:
            loop = OrbitLoop(parameters)
        else:
            loop.change(parameters)
        margins = loop.margins(loop.orbit_in(np.zeros(3)))
    except (ArithmeticError, RuntimeError, ValueError) as error:
        return loop, f"the margins of the closed loop are not known: {error}"
    if margins is UNSTABLE:
        return loop, "the closed loop is not stable on its orbit"
    small = shortfalls(margins, parameters)
    return loop, f"the closed loop has small margins: {'; '.join(small)}" if small else ""
