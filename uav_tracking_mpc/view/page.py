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

"""The server of a page: draws every aircraft of a source, and says what lines and colours mean."""

from __future__ import annotations

import contextlib
import functools
import logging
import math
import time
import weakref
from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np
import viser

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import MODE_COLOURS
from uav_tracking_mpc.view.panel import PANEL_PART, PanelPart
from uav_tracking_mpc.view.panel._html import ALARM, badge, block
from uav_tracking_mpc.view.scene import GREY, LIMIT, SCENE_ELEMENT, WIND, Colour, SceneElement
from uav_tracking_mpc.view.scene.orbits import SCALE
from uav_tracking_mpc.view.serving.guarded_server import GuardedServer
from uav_tracking_mpc.view.visitors import FLOWN, MISSION, NOW, NOW_TAG, Visitors
from uav_tracking_mpc.view.watched_flight import FlightSource, Sight, WatchedFlight

PLACE, WIDTH = (15.0, 15.0), 250.0  # pixels from the upper left corner of the scene
ROW = '<div style="display:flex;gap:0.5em;align-items:center">{}<span>{}</span></div>'
MARK = '<span style="flex:0 0 1.6em;height:0;border-top:3px {} rgb{}"></span>'
SQUARE = (
    '<span style="white-space:nowrap;margin-right:0.8em"><span style="display:inline-block;'
    'width:0.8em;height:0.8em;background:rgb{}"></span> {}</span> '
)
DISC = (
    '<span style="flex:0 0 1.6em;height:0.8em;border-radius:1em 1em 0 0;background:rgb{}"></span>'
)
BAR = '<span style="flex:0 0 1.6em;height:4px;background:linear-gradient(90deg,{})"></span>'

# A page saves what it has drawn itself, on its own background: viser's pictures end at 1 km.
SAVE = """
<button type="button" style="width:100%;margin-top:0.4em;padding:0.3em;font:inherit;cursor:pointer"
onclick="const drawn = document.querySelector('canvas[data-engine]');
const picture = document.createElement('canvas');
picture.width = drawn.width; picture.height = drawn.height;
const brush = picture.getContext('2d');
brush.fillStyle = getComputedStyle(document.body).backgroundColor;
brush.fillRect(0, 0, picture.width, picture.height);
brush.drawImage(drawn, 0, 0);
const link = document.createElement('a');
link.download = 'flight.png'; link.href = picture.toDataURL();
link.click();">Save a picture</button>
"""


def legend(colour: Colour, recorded: bool = False) -> str:
    """Rows of marks and words, as HTML.

    Args:
        colour: Of the first aircraft.
        recorded: Whether a record is shown, of which nothing can be steered.
    """
    flown = MODE_COLOURS[FallbackMode.OPTIMAL]
    slow_to_fast = ",".join(f"rgb{tuple(each)}" for each in SCALE.tolist())
    rows = [
        (MARK.format("solid", flown), "the plan: where it flies next"),
        (MARK.format("dashed", colour), "the orbit that is asked for"),
        (MARK.format("solid", flown), "a circle: the orbit that is planned, where that differs"),
        (BAR.format(slow_to_fast), "the last minute, from slow to fast over ground"),
        (MARK.format("solid", WIND), "the wind, which drifts as fast as this"),
        (MARK.format("solid", LIMIT), "a limit that is near"),
        (MARK.format("solid", colour), "the target, and where it is expected"),
        (MARK.format("solid", colour), "an arrow: velocity over ground"),
        (MARK.format("solid", GREY), "an arrow: velocity through the air"),
        (DISC.format(GREY), "a sphere about the target: not to be flown into"),
    ]
    modes = [SQUARE.format(tint, mode.value) for mode, tint in MODE_COLOURS.items()]
    return (
        '<div data-flight-legend style="font-size:0.75em;line-height:1.45;padding:0 0.7em 0.5em">'
        + "".join(ROW.format(*row) for row in rows)
        + f"Wings and plan, best first:<br>{''.join(modes)}<br>"
        + ("" if recorded else "<b>Drag the target</b> with the mouse. ")
        + ("Drag to look around." if recorded else "Drag elsewhere to look around.")
        + SAVE
        + "</div>"
    )


def add_legend(client: viser.ClientHandle, colour: Colour, recorded: bool) -> viser.PanelHandle:
    """Put it into the upper left of a page, folded.

    Args:
        client: The page.
        colour: Of the first aircraft.
        recorded: As of :func:`legend`.
    """
    panel = client.gui.add_panel()
    with panel.add_tab("What you see"):
        client.gui.add_html(legend(colour, recorded))
    panel.float(x=PLACE[0], y=PLACE[1], width=WIDTH)
    panel.minimize()
    return panel


logger = logging.getLogger(__name__)

FRAME_PERIOD = 0.05  # s of wall time between frames
UNSEEN_PERIOD = 0.2  # s, while no page is open; as often as the past is kept
COLOURS: tuple[Colour, ...] = (  # Okabe and Ito: told apart by everybody
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0), (86, 180, 233),
)  # fmt: skip
WORLD = "/world"  # node under which the scene hangs; cameras move it, page by page
PANEL_WIDTH = 340  # pixels


class Guarded:
    """Begins with the first sight, and is switched off by its first exception.

    What it has added is hidden then, lest something that is no longer true stays on the page.

    Args:
        name: By which it is found.
        api: Of viser, for the scene or the panel.
        begin: Makes it with that API; None while there is nothing to show.
        period: Time between updates in [s].

    Attributes:
        name: As above.
        failure: Why it was switched off, in words; empty while it works.
    """

    def __init__(
        self,
        name: str,
        api: Any,
        begin: Callable[[Any], SceneElement | PanelPart | None],
        period: float = 0.0,
    ) -> None:
        self.name, self.failure = name, ""
        self._period, self._due = period, 0.0
        self._api, self._begin = _Noting(api), begin
        self._shown: SceneElement | PanelPart | None = None

    def show(self, sight: Sight, now: float = math.inf) -> None:
        """Bring it up to date once that is due, unless it is switched off.

        Args:
            sight: Of the aircraft.
            now: Steady wall time in [s].
        """
        if self.failure or now < self._due:
            return
        self._due = now + self._period
        try:
            if self._shown is None:
                self._shown = self._begin(self._api)
            if self._shown is not None:
                self._shown.show(sight)
        except Exception as error:  # whatever it is, the page and the flight go on
            self.failure = f"{type(error).__name__}: {error}"
            logger.exception("page: %s is switched off", self.name)
            for handle in self._api.added.values():
                with contextlib.suppress(Exception):  # not all that can be added can be hidden
                    handle.visible = False


class _Noting:
    """Passes everything on to an API of viser, and notes what is added through it."""

    def __init__(self, api: Any) -> None:
        self._api = api
        self.added: weakref.WeakValueDictionary[int, Any] = weakref.WeakValueDictionary()

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._api, name)
        if not name.startswith("add_"):
            return found

        def add(*args: Any, **kwargs: Any) -> Any:
            handle = found(*args, **kwargs)
            self.added[id(handle)] = handle  # handles have no hash
            return _Sparing(handle) if isinstance(handle, viser.SceneNodeHandle) else handle

        return add


class _Sparing:
    """A node of the scene that is told only what is not so yet.

    Elements set all of their properties in each frame, of which few change, and viser converts each
    value before it compares. What it knows is asked, so that what a page has moved is put back.
    """

    def __init__(self, node: viser.SceneNodeHandle) -> None:
        object.__setattr__(self, "_node", node)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if not np.array_equal(getattr(self._node, name), value):
            setattr(self._node, name, value)


def elements_of(
    scene: viser.SceneApi, flight: WatchedFlight, colour: Colour, root: str = ""
) -> list[Guarded]:
    """All elements of one aircraft.

    Args:
        scene: Where to draw.
        flight: What is drawn.
        colour: Of this aircraft.
        root: Name of the node under which it hangs; by default it is one of the shared scene.
    """
    root = root or f"{WORLD}/{flight.name}"
    kinds: dict[str, Callable[..., SceneElement]] = {**SCENE_ELEMENT.all()}
    return [
        Guarded(name, scene, functools.partial(kind, root=root, flight=flight, colour=colour))
        for name, kind in kinds.items()
    ]


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
        self.colour, self._flight, self._source = colour, flight, source
        self._tab = tabs.add_tab(flight.name)
        with self._tab:
            back = "live" if source.clock is None else "replay"
            server.gui.add_html(NOW_TAG.format(back), order=-2e6)
            self._failures = server.gui.add_html("", order=-1e6, visible=False)  # above all parts

        kinds = sorted(PANEL_PART.all().items(), key=lambda item: item[1].order)
        self._shown = elements_of(server.scene, flight, colour) + [
            Guarded(name, server.gui, functools.partial(self._begin, kind), kind.period)
            for name, kind in kinds
        ]

    def _begin(self, kind: type[PanelPart], gui: Any) -> PanelPart | None:
        if not kind.fits(self._flight, self._source):
            return None
        with self._tab:
            return kind(gui, self._flight, self._source)

    def show(self, now: float) -> Sight | None:
        sight = self._flight.sight
        if sight is None:
            return None
        for shown in self._shown:
            shown.show(sight, now)
        failed = [shown for shown in self._shown if shown.failure]
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
        self._visitors = Visitors(
            self._server,
            source,
            WORLD,
            lambda scene, root, flight: elements_of(
                scene, flight, self._drawn[flight.name].colour, root
            ),
            lambda client: add_legend(client, COLOURS[0], source.clock is not None),
        )
        self._server.answers |= {
            NOW: self._visitors.now,
            FLOWN: self._visitors.flown,
            MISSION: self._visitors.mission,
        }
        self._server.gui.main_panel.dock_right()  # beside the scene and not upon it
        self._server.gui.main_panel.set_width(PANEL_WIDTH)
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
            self._visitors.show(watched)

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
            seen = bool(self._server.get_clients())
            due = max(due + (FRAME_PERIOD if seen else UNSEEN_PERIOD), time.monotonic())
            time.sleep(max(due - time.monotonic(), 0.0))

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()
        self._source.close()
