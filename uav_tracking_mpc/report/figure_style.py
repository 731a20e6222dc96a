"""Colours, type and resolution that all figures share.

Colours are those of Okabe and Ito, which people with any common colour vision tell apart. Figures
are drawn with matplotlib's objects on the Agg canvas: no window system, no state shared with
whatever else in the process draws.
"""

from __future__ import annotations

import io
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

BLUE = "#0072B2"
VERMILLION = "#D55E00"
GREEN = "#009E73"
GREY = "#7F7F7F"
LIGHT_GREY = "#D9D9D9"
BLACK = "#1A1A1A"

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


def new_figure(width: float, height: float) -> Figure:
    """An empty figure that belongs to no window.

    Args:
        width: In [inch].
        height: In [inch].
    """
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def png(figure: Figure) -> bytes:
    """The figure as a PNG file of exactly its own size, :data:`DPI` dots per inch."""
    buffer = io.BytesIO()
    # A user's savefig.bbox = tight would change the size.
    with matplotlib.rc_context({**STYLE, "savefig.bbox": None}):
        figure.savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()
