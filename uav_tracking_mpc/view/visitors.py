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

"""Each open page: what its script asks for and is told, and its view of the past.

A page that looks back has a scene of its own, of its own time, in place of the one that all share.
"""

from __future__ import annotations

import json
import math
import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.cameras import FirstView, Seat, Watched, covered
from uav_tracking_mpc.view.flight_history import EXACT, MODES, FlightHistory, legend, row_of, told
from uav_tracking_mpc.view.panel.mission_file import fly_and_tell
from uav_tracking_mpc.view.panel.readings import readings
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    SILENT,
    FlightSource,
    PlayClock,
    Sight,
    WatchedFlight,
)

PAST_WORLD = "/past"  # node under which the scene of a past time hangs
LAST = 1e6  # order in the panel
ERROR = 2  # level of a node, as in diagnostic_msgs
NOW, FLOWN, MISSION = "/flight/now", "/flight/flown", "/flight/mission"  # paths of the answers
# By it the script knows which client of viser it belongs to.
NAME_TAG = '<span data-flight-page="{}" hidden></span>'
# By it the page knows what of the panel is of now; it reads the words while it looks back.
NOW_TAG = (
    "<span data-flight-panel>Readings and controls are of another time than the picture. "
    "They come back with <b>{}</b>.</span>"
)

Alert = tuple[int, str]
Query = Mapping[str, list[str]]


def alert_of(sight: Sight, clock: PlayClock | None = None) -> Alert | None:
    """What is wrong with a flight.

    Args:
        sight: Of now.
        clock: Of its record; None where it is flown now.

    Returns:
        0 to know, 1 to attend to or 2 for wrong, and words; None where all is well.
    """
    if clock is not None and clock.time >= clock.end:
        return 0, "The record ends here."
    statuses = sight.statuses
    if statuses and all(status.level == SILENT for status in statuses):
        return 1, f"The flight has ended, or all of its nodes are silent. {sight.reason}".strip()
    for status in statuses:
        if status.node == CONTROLLER and status.level == SILENT:
            return 2, f"The controller is silent: {status.words}"
    if sight.mode is FallbackMode.SILENCE:
        return 2, f"Nothing is commanded: {sight.reason or 'the controller is silent'}"
    for status in statuses:
        if status.level == ERROR:
            return 2, f"{status.node}: {status.words}"
    return None


def figures(sight: Sight, tracking: TrackingParameters | None) -> dict[str, Any]:
    """A sight as JSON holds it, None for what is not known.

    Args:
        sight: Of the aircraft.
        tracking: What its controller flies by; None where that is not known.

    Returns:
        ``time`` in [s]; ``mode``, an index, and its ``reason``; ``readings`` by name, each value,
        error, least and most in the unit that stands first; ``course`` and ``wind_from`` in [deg]
        from north, clockwise, ``wind`` in [m/s]; ``row``, as of the strip.
    """
    wind = (math.nan, math.nan) if sight.wind is None else tuple(sight.wind[:2].tolist())
    shown = {
        reading.name: [reading.unit, *(told(number) for number in reading[2:])]
        for reading in readings(sight, tracking)
    }
    return {
        "time": told(sight.time, EXACT),
        "mode": MODES.index(sight.mode),
        "reason": sight.reason,
        "readings": shown,
        "course": told(math.degrees(0.5 * math.pi - sight.heading) % 360.0),
        "wind": told(math.hypot(*wind)),
        "wind_from": told(math.degrees(math.atan2(-wind[0], -wind[1])) % 360.0),
        "row": row_of(sight, tracking),
    }


class PastFlight(WatchedFlight):
    """A flight as it was; it cannot be steered.

    Args:
        flight: That goes on.
        history: Of it.

    Attributes:
        sight: What there was to see at the time that was gone to last.
        tracking: What its controller flew by when that was gone to.
    """

    sight: Sight | None = None

    def __init__(self, flight: WatchedFlight, history: FlightHistory) -> None:
        self.name, self._flight, self._history = flight.name, flight, history

    def go_to(self, time: float) -> Sight | None:
        """Show a time.

        Args:
            time: Of the flight's clock in [s].

        Returns:
            What there was to see; None where nothing is known.
        """
        self.sight, self.tracking = self._history.at(time), self._flight.tracking
        return self.sight

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`.

        Args:
            span: How far back from the shown time in [s].
        """
        if self.sight is None:
            return []
        return self._history.between(self.sight.time - span, self.sight.time)


DrawnBy = Callable[[viser.SceneApi, str, WatchedFlight], Sequence[Any]]  # as of page.elements_of
Flown = Mapping[str, tuple[WatchedFlight, FlightHistory]]


def set_theme(gui: viser.GuiApi, dark: bool) -> None:
    """Give pages their colours.

    Args:
        gui: Of all pages, or of one.
        dark: Whether they are dark.
    """
    gui.configure_theme(show_share_button=False, show_logo=False, dark_mode=dark)


class Visitor:
    """One open page: from where it looks, at what time, in which colours.

    Args:
        client: The page.
        world: Name of the node under which the shared scene hangs.
        firsts: Where the cameras of pages began, newest last.
        draw: Begins to draw an aircraft: of a scene, the name of a node and a flight; answers what
            draws each of its sights.
        legend: Its legend, folded.

    Attributes:
        seat: From where it looks.
        asked: Time that it looks at in [s]; None for now.
        past: All aircraft as it sees them, by name, where it looks back; empty else.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        world: str,
        firsts: Sequence[NDArray[np.float64]],
        draw: DrawnBy,
        legend: viser.PanelHandle,
    ) -> None:
        self.client, self._draw, self._legend = client, draw, legend
        self.seat = Seat(client, world, firsts)
        self.asked: float | None = None
        self.past: dict[str, Watched] = {}
        self._shown: float | None = None  # time that the scene of the past shows
        self._drawn: dict[str, tuple[PastFlight, Sequence[Any]]] = {}
        self._frame = client.scene.add_frame(PAST_WORLD, show_axes=False, visible=False)
        self._asks_for_dark: bool | None = None  # before its browser has said so
        self._dark: Any = client.gui.add_checkbox("Dark", False, order=LAST)
        self._dark.on_update(lambda _: set_theme(client.gui, self._dark.value))
        client.gui.add_html(NAME_TAG.format(client.client_id), order=-1e6)

    def show(self, watched: Mapping[str, Watched], flown: Flown) -> None:
        """Draw the past where the page looks at it, and follow what it follows.

        Args:
            watched: All aircraft that are seen now, by name.
            flown: All aircraft that were seen, by name, with what was kept of them.
        """
        with self.client.atomic():
            if self.asked != self._shown:
                self._shown = self.asked
                self.past = {} if self.asked is None else self._at(self.asked, flown)
                self._frame.visible = bool(self.past)
                self.seat.world.visible = not self.past
            if watched:
                frame = self._frame if self.past else None
                self.seat.show(tuple(watched), self.past or watched, frame)

    def _at(self, time: float, flown: Flown) -> dict[str, Watched]:
        watched: dict[str, Watched] = {}
        for name, (flight, history) in flown.items():
            if name not in self._drawn:
                past = PastFlight(flight, history)
                elements = self._draw(self.client.scene, f"{PAST_WORLD}/{name}", past)
                self._drawn[name] = past, elements
            past, elements = self._drawn[name]
            sight = past.go_to(time)
            if sight is not None:
                watched[name] = past, sight
                for element in elements:
                    element.show(sight)
        return watched

    def told_width(self, width: float) -> None:
        """Unfold the legend once there is room for it, and fold it once there is none.

        Args:
            width: Of the scene in pixels of the page.
        """
        aspect = self.client.camera.aspect
        before, now = (covered(wide, aspect) > 0.0 for wide in (self.seat.width, width))
        if now is not before:
            (self._legend.expand if now else self._legend.minimize)()
        self.seat.width = width

    def follow_theme(self, dark: str) -> None:
        """Follow the browser until a hand changes it, and again when the browser changes.

        Args:
            dark: 1 where it asks for dark pages, 0 where it does not; anything else is ignored.
        """
        if dark in ("0", "1") and self._asks_for_dark is not (dark == "1"):
            self._asks_for_dark = self._dark.value = dark == "1"


class Visitors:
    """All open pages.

    Args:
        server: Of the pages.
        source: What is shown.
        world: Name of the node under which the shared scene hangs.
        draw: Begins to draw an aircraft anew, see :class:`Visitor`.
        add_legend: To a page, folded.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        source: FlightSource,
        world: str,
        draw: DrawnBy,
        add_legend: Callable[[viser.ClientHandle], viser.PanelHandle],
    ) -> None:
        self._source, self._first = source, FirstView(server)
        self._server = secrets.token_hex(8)  # a page that was served by another one is old
        self._visitors: dict[int, Visitor] = {}
        self._flown: dict[str, tuple[WatchedFlight, FlightHistory]] = {}
        self._watched: Mapping[str, Watched] = {}
        self._at = math.inf  # s, when the last frame was drawn; the first one may take long

        def join(client: viser.ClientHandle) -> None:
            panel = add_legend(client)
            visitor = Visitor(client, world, self._first.places, draw, panel)
            self._visitors[client.client_id] = visitor

        def leave(client: viser.ClientHandle) -> None:
            self._visitors.pop(client.client_id, None)

        set_theme(server.gui, False)
        server.on_client_connect(join)
        server.on_client_disconnect(leave)

    def show(self, watched: Mapping[str, Watched]) -> None:
        """Take note of a frame, and show each page what it looks at.

        Args:
            watched: All aircraft that are seen, by name.
        """
        for name, (flight, sight) in watched.items():
            if name not in self._flown:
                self._flown[name] = flight, FlightHistory(flight, self._source.clock)
            self._flown[name][1].note(sight)
        self._watched = watched
        if watched:
            self._first.show(next(iter(watched.values())))
        for visitor in list(self._visitors.values()):
            visitor.show(watched, self._flown)
        self._at = time.monotonic()

    def now(self, query: Query) -> str:
        """What one page shows, and what is wrong.

        Args:
            query: ``page``, its number; ``time``, where it looks back; ``dark``, 1 or 0; ``wide``,
                its scene in pixels.

        Returns:
            JSON.
        """
        number = _number(query, "page")
        visitor = None if number is None else self._visitors.get(int(number))
        shown = watched = self._watched  # another thread may draw meanwhile
        view, name = "", next(iter(shown), "")
        if number is not None and visitor is not None:
            visitor.asked = _number(query, "time")
            visitor.follow_theme(query.get("dark", [""])[0])
            if width := _number(query, "wide"):
                visitor.told_width(width)
            shown = visitor.past or shown
            view, name = visitor.seat.choice
        clock, live = self._source.clock, watched.get(name)
        told_now: dict[str, Any] = {
            "server": self._server,
            "known": visitor is not None,
            "age": round(max(time.monotonic() - self._at, 0.0), 2),
            "names": list(watched),
            "name": name,
            "view": view,
            "record": None if clock is None else [clock.begin, clock.end],
            "past": shown is not watched,
            "live": None if live is None else told(live[1].time, EXACT),
            "alert": (1, self._source.words) if live is None else alert_of(live[1], clock),
            "sight": figures(shown[name][1], shown[name][0].tracking) if name in shown else None,
            **legend(),
        }
        return json.dumps(told_now, allow_nan=False)

    def flown(self, query: Query) -> str:
        """What the strip of one aircraft draws.

        Args:
            query: ``name`` of the aircraft; ``since``, after which time, in [s].

        Returns:
            JSON, see :meth:`FlightHistory.as_json`; an empty object where there is no such
            aircraft.
        """
        kept = self._flown.get(query.get("name", [""])[0])
        since = _number(query, "since")
        return "{}" if kept is None else kept[1].as_json(-math.inf if since is None else since)

    def mission(self, query: Query) -> str:
        """Begin to fly a mission that came with an address; the page is told what comes of it.

        Args:
            query: ``page``, its number; ``name`` of the aircraft; ``mission``, a scenario file.

        Returns:
            JSON: ``refused``, why nothing was begun, or an empty object.
        """
        number = _number(query, "page")
        name, text = (query.get(key, [""])[0] for key in ("name", "mission"))
        visitor = None if number is None else self._visitors.get(int(number))
        steering = self._flown[name][0].steering if name in self._flown else None
        if visitor is None or steering is None:
            return json.dumps({"refused": "this flight cannot be steered"})
        fly_and_tell(visitor.client, steering, text.encode())
        return "{}"


def _number(query: Query, name: str) -> float | None:
    """A finite number of a query; None where there is none."""
    try:
        value = float(query.get(name, ["nan"])[0])
    except ValueError:
        return None
    return value if math.isfinite(value) else None
