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

"""All that was flown, thinned as it grows: what a page's time strip draws and goes back to."""

from __future__ import annotations

import json
import math
import threading
import time
from bisect import bisect_right
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS
from uav_tracking_mpc.report.mode_colours import MODE_COLOURS, mode_words
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.panel.readings import readings
from uav_tracking_mpc.view.watched_flight import PAST_PERIOD, PlayClock, Sight, WatchedFlight

MOST = 6000  # sights that are kept: after 20 min every second one goes, and so on
MOST_EVENTS = 1000  # changes of mode and reports of nodes that are kept
EXACT = 17  # digits that a time needs, for it may count from 1970 and is asked for again
SAME = 1e-6  # s by which times may miss each other
FILLING = 0.005  # s of wall time a frame in which a record is read for its strip
MODES = (None, *MODE_COLOURS)
COLUMNS = (
    "time", "mode", "range error", "altitude", "bank", "airspeed", "wind", "cost", *ERRORS
)  # fmt: skip


class Event(NamedTuple):
    """Something that is marked in the strip.

    Attributes:
        time: Of the flight's clock in [s].
        level: 0 good, 1 to attend to, 2 wrong.
        words: What people read.
    """

    time: float
    level: int
    words: str


def told(value: float | None, digits: int = 5) -> float | None:
    """A number as JSON holds it: None where it is not finite.

    Args:
        value: In any unit [-].
        digits: That are kept.
    """
    return float(f"{value:.{digits}g}") if value is not None and math.isfinite(value) else None


def weighted_errors(sight: Sight, tracking: TrackingParameters | None) -> list[float]:
    """What each error of now weighs in the cost of one stage, by ``ERRORS`` [-].

    They are those about the orbit that is asked for: the optimal cost sums over all stages, about
    the orbit that the plan ends on, and has further terms.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    weights = [math.nan] * len(ERRORS) if tracking is None else tracking.state_weights
    errors = [sight.errors.get(name, math.nan) for name in ERRORS]
    return [float(weight * error**2) for weight, error in zip(weights, errors, strict=True)]


def row_of(sight: Sight, tracking: TrackingParameters | None) -> list[float | None]:
    """What the strip draws of a sight, by ``COLUMNS``.

    Time in [s], index of the mode in ``MODES``, range error and height in [m], bank in [deg],
    airspeed and wind in [m/s], costs [-]; None where it is not known.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.
    """
    values = {reading.name: reading.value for reading in readings(sight, tracking)}
    wind = math.nan if sight.wind is None else float(np.linalg.norm(sight.wind[:2]))
    figures = (
        sight.errors.get("range_error"), values["Altitude"], values["Bank"], sight.airspeed, wind,
        sight.cost, *weighted_errors(sight, tracking),
    )  # fmt: skip
    time = told(sight.time, EXACT)
    return [time, MODES.index(sight.mode), *(told(value, 4) for value in figures)]


def _level(mode: FallbackMode | None) -> int:
    return 2 if mode is FallbackMode.SILENCE else int(mode is not None and not mode.nominal)


class FlightHistory:
    """What was seen of a flight, from its first sight on.

    A flight that goes on is noted as it is drawn; a record is read from begin to end, a few sights
    each frame. Requests read it while a frame writes it.

    Args:
        flight: That is followed.
        clock: Of its record; None where it is flown now.
        most: Sights that are kept.

    Attributes:
        generation: Grows where time began anew, and all that was kept went.
    """

    def __init__(
        self, flight: WatchedFlight, clock: PlayClock | None = None, most: int = MOST
    ) -> None:
        self._flight, self._clock, self._most = flight, clock, most
        self.generation = 0
        self._lock = threading.Lock()
        self._step = PAST_PERIOD  # s
        self._due = -math.inf  # when a record is read next, in [s] of it
        self._forget()
        if clock is not None:
            self._step = max(PAST_PERIOD, (clock.end - clock.begin) / (most - 1))
            self._due = clock.begin

    def _forget(self) -> None:
        self._times: list[float] = []
        self._sights: list[Sight] = []
        self._rows: list[str] = []
        self._events: deque[Event] = deque(maxlen=MOST_EVENTS)
        self._mode: FallbackMode | None = None
        self._levels: dict[str, int] = {}

    def note(self, sight: Sight) -> None:
        """Keep what is seen now, or read on in the record.

        Args:
            sight: Of now.
        """
        if self._clock is None:
            last = self._times[-1] if self._times else -math.inf
            if sight.time > last + 2.0 * PAST_PERIOD:  # it flies faster than frames are drawn
                for seen in self._flight.past(sight.time - last):
                    if last < seen.time < sight.time:
                        self._keep(seen)
            self._keep(sight)
            return
        self.read(FILLING)

    def read(self, longest: float = math.inf) -> None:
        """Read on in the record, to its end where there is time.

        Args:
            longest: Wall time that it may take in [s].
        """
        assert self._clock is not None, "there is no record to read"
        until = time.perf_counter() + longest
        while self._due <= self._clock.end + SAME and time.perf_counter() < until:
            recorded = self._flight.at(self._due, whole=False)
            if recorded is not None:
                self._keep(recorded)
            self._due += self._step

    def _keep(self, sight: Sight) -> None:
        with self._lock:
            if self._times and sight.time < self._times[-1]:
                self.generation += 1
                self._step = PAST_PERIOD
                self._forget()
            self._mark(sight)
            if self._times and sight.time < self._times[-1] + self._step - SAME:
                return
            self._times.append(sight.time)
            self._sights.append(replace(sight, statuses=()))
            self._rows.append(json.dumps(row_of(sight, self._flight.tracking)))
            if len(self._times) > self._most:
                for kept in (self._times, self._sights, self._rows):
                    del kept[1::2]
                self._step *= 2.0

    def _mark(self, sight: Sight) -> None:
        """Note changes of mode, and nodes that report worse than before."""
        if sight.mode is not self._mode:
            self._mode = sight.mode
            words = mode_words(sight.mode) + (f": {sight.reason}" if sight.reason else "")
            self._events.append(Event(sight.time, _level(sight.mode), words))
        for status in sight.statuses:
            before = self._levels.get(status.node, 0)
            self._levels[status.node] = status.level
            if status.level > before:
                level = min(status.level, 2)
                self._events.append(Event(sight.time, level, f"{status.node}: {status.words}"))

    def at(self, time: float) -> Sight | None:
        """What there was to see at a time; of a flight that goes on, what was kept by then.

        Args:
            time: In [s] of the flight's clock; the nearest one that is known is taken.
        """
        if self._clock is not None:
            seen = self._flight.at(min(max(time, self._clock.begin), self._clock.end))
            if seen is not None:
                return seen
        with self._lock:
            if not self._times:
                return None
            return self._sights[max(bisect_right(self._times, time + SAME) - 1, 0)]

    def between(self, begin: float, end: float) -> Sequence[Sight]:
        """What was kept of a span, oldest first.

        Args:
            begin: In [s].
            end: In [s]; sights of that time belong to it.
        """
        with self._lock:
            return self._sights[bisect_right(self._times, begin) : bisect_right(self._times, end)]

    def as_json(self, since: float = -math.inf) -> str:
        """What the strip draws.

        Args:
            since: Rows after it, and events at it and after, in [s]: time may stand.

        Returns:
            ``generation``, ``columns``, ``rows``, ``events``, and ``modes``, each with its colour.
        """
        with self._lock:
            rows = ",".join(self._rows[bisect_right(self._times, since) :])
            events = [event for event in self._events if event.time >= since]
            generation = self.generation
        head = json.dumps({"generation": generation, "events": events, **legend()}, allow_nan=False)
        return f'{head[:-1]}, "rows": [{rows}]}}'


def legend() -> Mapping[str, Any]:
    """What the columns of the rows are, and words and colour of each mode."""
    modes = [
        (mode_words(mode), MODE_COLOURS[FallbackMode.SILENCE if mode is None else mode])
        for mode in MODES
    ]
    return {"columns": COLUMNS, "modes": modes}
