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

"""The server of a page: draws every aircraft of a source, twenty times a second."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from html import escape
from typing import Any

import viser

from uav_tracking_mpc.parameters.registry import PANEL_PART, SCENE_ELEMENT
from uav_tracking_mpc.view.appearance import Appearance
from uav_tracking_mpc.view.cameras import Cameras
from uav_tracking_mpc.view.guarded import Guarded
from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, badge, block
from uav_tracking_mpc.view.scene import Colour, SceneElement
from uav_tracking_mpc.view.serving.guarded_server import GuardedServer
from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.watched_flight import FlightSource, WatchedFlight

logger = logging.getLogger(__name__)

FRAME_PERIOD = 0.05  # s of wall time between frames
COLOURS: tuple[Colour, ...] = (  # Okabe and Ito: told apart by everybody
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0), (86, 180, 233),
)  # fmt: skip
WORLD = "/world"  # node under which the scene hangs; cameras move it, page by page


def elements_of(scene: viser.SceneApi, flight: WatchedFlight, colour: Colour) -> list[Guarded]:
    """All elements of one aircraft.

    Args:
        scene: Where to draw.
        flight: What is drawn.
        colour: Of this aircraft.
    """

    def begin(kind: type[SceneElement]) -> Callable[[Any], SceneElement]:
        return lambda scene: kind(scene, f"{WORLD}/{flight.name}", flight, colour)

    return [Guarded(name, scene, begin(kind)) for name, kind in SCENE_ELEMENT.all().items()]


class _Drawn:
    """One aircraft on the page."""

    def __init__(
        self,
        server: viser.ViserServer,
        tabs: viser.GuiTabGroupHandle,
        source: FlightSource,
        flight: WatchedFlight,
        colour: Colour,
    ) -> None:
        self._flight, self._tab = flight, tabs.add_tab(flight.name)
        with self._tab:
            self._failures = server.gui.add_html("", order=-1e6, visible=False)  # above all parts

        def begin_part(kind: type[PanelPart]) -> Callable[[Any], PanelPart | None]:
            def begin(gui: Any) -> PanelPart | None:
                if not kind.fits(flight, source):
                    return None
                with self._tab:
                    return kind(gui, flight, source)

            return begin

        self._elements = elements_of(server.scene, flight, colour)
        kinds = sorted(PANEL_PART.all().items(), key=lambda item: item[1].order)
        self._parts = [Guarded(name, server.gui, begin_part(kind)) for name, kind in kinds]
        self._periods = {name: kind.period for name, kind in kinds}
        self._due: dict[str, float] = {}

    def show(self, now: float) -> Sight | None:
        sight = self._flight.sight
        if sight is None:
            return None
        for element in self._elements:
            element.show(sight)
        for part in self._parts:
            if now >= self._due.get(part.name, 0.0):
                self._due[part.name] = now + self._periods[part.name]
                part.show(sight)
        failed = [each for each in (*self._elements, *self._parts) if each.failure]
        self._failures.visible = bool(failed)
        self._failures.content = block(
            *(f"{badge('switched off', ALARM)} {escape(f'{f.name}: {f.failure}')}" for f in failed)
        )
        return sight


class Page:
    """Serves one source.

    Args:
        source: What is shown.
        host: Address to listen at; without one 127.0.0.1.
        port: Port to listen at; without one the first free one from 8080 on.

    Attributes:
        address: Where a browser finds the page, with the token.
    """

    def __init__(
        self, source: FlightSource, host: str | None = None, port: int | None = None
    ) -> None:
        self._source = source
        self._server = GuardedServer(host, port, label="uav_tracking")
        self.address = self._server.address
        self._appearance = Appearance(self._server)
        self._cameras = Cameras(self._server, WORLD)
        self._tabs = self._server.gui.add_tab_group()  # one for each aircraft
        self._drawn: dict[str, _Drawn] = {}
        self._words = self._server.gui.add_markdown(source.words, visible=bool(source.words))

    def draw(self) -> None:
        """One frame."""
        now, watched = time.monotonic(), {}
        with self._server.atomic():
            if (words := self._source.words) != self._words.content:
                self._words.content, self._words.visible = words, bool(words)
            for flight in self._source.flights():
                if flight.name not in self._drawn:
                    colour = COLOURS[len(self._drawn) % len(COLOURS)]
                    self._drawn[flight.name] = _Drawn(
                        self._server, self._tabs, self._source, flight, colour
                    )
                sight = self._drawn[flight.name].show(now)
                if sight is not None:
                    watched[flight.name] = flight, sight
            self._cameras.show(watched)

    def serve(self, ended: Callable[[], bool]) -> None:
        """Draw until it is over.

        Args:
            ended: Whether it is.
        """
        due = time.monotonic()
        failure = ""
        while not ended():
            try:
                self.draw()
            except Exception as error:  # a flight must not end because it is watched
                if failure != (failure := f"{type(error).__name__}: {error}"):
                    logger.exception("page: a frame was not drawn")
            due = max(due + FRAME_PERIOD, time.monotonic())
            time.sleep(max(due - time.monotonic(), 0.0))

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()
        self._source.close()
