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

"""How each page looks: light or dark, and what its colours mean."""

from __future__ import annotations

import viser

from uav_tracking_mpc.report.mode_colours import MODE_COLOURS, Colour
from uav_tracking_mpc.view.scene._palette import LIMIT, WIND

LAST = 1e6  # order in the panel

SQUARE = '<span style="color:rgb({},{},{})">&#9632;</span>'


def legend() -> str:
    """What the colours mean, as HTML."""
    rows = [f"{_square(colour)} {mode.value}" for mode, colour in MODE_COLOURS.items()]
    return (
        '<div style="font-size:0.8em;line-height:1.5;padding:0 0.5em">'
        "<b>Wings, plan and the orbit it ends on</b>: what is flown<br>"
        + "<br>".join(rows)
        + "<br><b>Fuselage, track, target and dashed orbit</b>: the aircraft's own colour; the "
        "dashed orbit is the one asked for"
        f"<br>{_square(WIND)} wind and drift<br>{_square(LIMIT)} limits</div>"
    )


def _square(colour: Colour) -> str:
    return SQUARE.format(*colour)


def set_theme(gui: viser.GuiApi, dark: bool = False) -> None:
    """Light or dark.

    Args:
        gui: Of all pages, or of one.
        dark: Whether the background is dark.
    """
    gui.configure_theme(show_share_button=False, show_logo=False, dark_mode=dark)


class Appearance:
    """A switch and a legend on every page.

    Args:
        server: Of the pages.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        set_theme(server.gui)
        server.on_client_connect(self._join)

    def _join(self, client: viser.ClientHandle) -> None:
        dark = client.gui.add_checkbox("Dark", False, order=LAST)
        dark.on_update(lambda _: set_theme(client.gui, dark.value))
        with client.gui.add_folder("Colours", order=LAST + 1.0, expand_by_default=False):
            client.gui.add_html(legend())
