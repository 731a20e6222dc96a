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

"""What lines and colours of the scene mean: a small panel beside it, which can be folded."""

from __future__ import annotations

import viser

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.report.mode_colours import MODE_COLOURS, Colour
from uav_tracking_mpc.view.scene._drawing import LIMIT, WIND
from uav_tracking_mpc.view.scene.tracks import SCALE

PLACE, WIDTH = (15.0, 15.0), 250.0  # pixels from the upper left corner of the scene
ROOM = 920  # pixels; beside less of a scene it would stand upon the orbit
ROW = '<div style="display:flex;gap:0.5em;align-items:center">{}<span>{}</span></div>'
MARK = '<span style="flex:0 0 1.6em;height:0;border-top:3px {} rgb{}"></span>'
SQUARE = '<span title="{}" style="flex:0 0 0.8em;height:0.8em;background:rgb{}"></span>'
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


def legend(colour: Colour) -> str:
    """Rows of marks and words, as HTML.

    Args:
        colour: Of the first aircraft.
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
    ]
    modes = [SQUARE.format(mode.value, tint) for mode, tint in MODE_COLOURS.items()]
    return (
        '<div data-flight-legend style="font-size:0.75em;line-height:1.45;padding:0 0.7em 0.5em">'
        + "".join(ROW.format(*row) for row in rows)
        + ROW.format("".join(modes), "wings and plan, best first")
        + "<b>Drag the target</b> with the mouse. Drag elsewhere to look around."
        + SAVE
        + "</div>"
    )


def add_legend(client: viser.ClientHandle, colour: Colour) -> None:
    """Put it into the upper left of a page, folded where the page is small.

    Args:
        client: The page.
        colour: Of the first aircraft.
    """
    panel = client.gui.add_panel()
    with panel.add_tab("What you see"):
        client.gui.add_html(legend(colour))
    panel.float(x=PLACE[0], y=PLACE[1], width=WIDTH)
    if client.camera.image_width < ROOM:
        panel.minimize()
