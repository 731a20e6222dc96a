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

"""Colours, type and resolution that all figures share.

Colours are those of Okabe and Ito, which people with any common colour vision tell apart. Figures
are drawn with matplotlib's objects on the Agg canvas: no window system, no state shared with
whatever else in the process draws.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.mode_colours import MODE_COLOURS

BLUE = "#0072B2"
VERMILLION = "#D55E00"
GREEN = "#009E73"
GREY = "#7F7F7F"
LIGHT_GREY = "#D9D9D9"
BLACK = "#1A1A1A"
PURPLE = "#CC79A7"
LAWS = {"nmpc": BLUE, "l1": VERMILLION, "npfg": PURPLE, "vector_field": GREEN}
MODES = {mode: "#{:02X}{:02X}{:02X}".format(*colour) for mode, colour in MODE_COLOURS.items()}
# Where no colour is reserved.
OTHERS = ("#E69F00", "#56B4E9", "#7A5195", "#8C6D31")

DPI = 160

STYLE: dict[Any, Any] = {  # keys that matplotlib knows, whatever its version
    "axes.axisbelow": True,
    "axes.edgecolor": "#4D4D4D",
    "axes.formatter.use_mathtext": True,
    "axes.grid": True,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.titlesize": 9.0,
    "figure.facecolor": "white",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "text.usetex": False,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
}


def colours(names: Iterable[str]) -> dict[str, str]:
    """Colour of each law, by name: always the same for those that come with the package.

    Args:
        names: Of any number of laws; those that nobody has seen take other colours, in order.
    """
    spare = cycle(OTHERS)
    return {name: LAWS.get(name) or next(spare) for name in dict.fromkeys(names)}


@contextmanager
def drawing(width: float, height: float) -> Iterator[Figure]:
    """An empty figure that belongs to no window, to be drawn in the style of all figures.

    Args:
        width: Of the figure [inch].
        height: Of the figure [inch].
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width, height), dpi=DPI)
        FigureCanvasAgg(figure)
        yield figure


def png(figure: Figure) -> bytes:
    """The figure as a PNG file of exactly its own size, :data:`DPI` dots per inch.

    Args:
        figure: What to save.
    """
    buffer = io.BytesIO()
    # A user's savefig.bbox = tight would change the size.
    with matplotlib.rc_context({**STYLE, "savefig.bbox": None}):
        figure.savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def save_figure(figure: Figure, path: Path) -> bytes:
    """Write a figure as a PNG file.

    Args:
        figure: What to save.
        path: Where the file shall be; its folder exists.

    Returns:
        Content of the file.
    """
    content = png(figure)
    write_atomically(Path(path), content)
    return content
