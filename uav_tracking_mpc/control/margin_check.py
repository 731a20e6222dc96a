"""Whether the margins of the closed loop are as large as the parameters ask, in words.

It takes some tenths of a second and belongs where nothing waits for a command: where a flight is
configured, and after a change in flight in a thread of its own (:class:`MarginWatch`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from uav_tracking_mpc.control.loop_margins import CHANNELS, LoopMargins
from uav_tracking_mpc.control.orbit_loop import OrbitLoop
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


class MarginWatch:
    """Judges the margins of parameters in a thread of its own.

    Of changes that come faster than they can be judged only the latest counts.

    Args:
        report: Called in that thread with a warning in words.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        self._loop: OrbitLoop | None = None
        self._lock = threading.Lock()
        self._next: TrackingParameters | None = None
        self._thread: threading.Thread | None = None

    def judge(self, parameters: TrackingParameters) -> None:
        """Judge parameters soon; returns at once.

        Args:
            parameters: What is flown from now on; fixed ones are those of the first call.
        """
        with self._lock:
            self._next = parameters
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="margins")
                self._thread.start()

    def wait(self) -> None:
        """Return when all that was asked is judged."""
        thread = self._thread
        if thread is not None:
            thread.join()

    def _work(self) -> None:
        while True:
            with self._lock:
                parameters, self._next = self._next, None
                if parameters is None:
                    self._thread = None
                    return
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
    small = shortfalls(margins, parameters)
    return loop, f"the closed loop has small margins: {'; '.join(small)}" if small else ""
