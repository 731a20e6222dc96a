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

r"""A Nichols chart of each channel's return ratio, and the margins around the orbit.

A disk of size alpha about the critical point is left free by l where
:math:`|(1 - l) / (1 + l)| < 2 / \alpha`; its edge is :math:`l = (1 - m) / (1 + m)` with
:math:`m = (2 / \alpha) e^{i\vartheta}`.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from uav_tracking_mpc.margins.loop_margins import CHANNELS
from uav_tracking_mpc.report.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT_GREY,
    VERMILLION,
    drawing,
)
from uav_tracking_mpc.studies.margins.margin_study import MarginStudy, as_json, margin_table
from uav_tracking_mpc.studies.study import Study

SIZE = (9.5, 4.4)  # [inch]
COLOURS = dict(zip(CHANNELS, (BLUE, VERMILLION, GREEN), strict=True))
DISKS = (0.5, 1.0)
DELAYS, DELAY_TICKS = (0.1, 10.0), (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # [s]
PHASES, GAINS = (-360.0, 0.0), (-40.0, 40.0)  # [deg], [dB] that are drawn


def margins(study: MarginStudy) -> Study:
    """The study: numbers, table and figure.

    Args:
        study: Of a configuration.
    """
    table = margin_table(study)
    return Study(
        name="margins",
        content=as_json(study),
        words=[table, *(f"too small, {line}" for line in study.shortfalls)],
        written="figure: {}/margins.png",
        figures={"margins": partial(margin_figure, study)},
        tables={"margins": table},
    )


def margin_figure(study: MarginStudy) -> Figure:
    """The figure.

    Args:
        study: Of a configuration.
    """
    with drawing(*SIZE) as figure:
        chart, around = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        _draw_chart(chart, study)
        _draw_delays(around, study)
        figure.subplots_adjust(left=0.07, right=0.985, bottom=0.12, top=0.92, wspace=0.22)
    return figure


def _draw_chart(axes: Axes, study: MarginStudy) -> None:
    for disk in DISKS:
        edge = (2.0 / disk) * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
        phase, gain = _nichols((1.0 - edge) / (1.0 + edge))
        axes.fill(np.mod(phase, -360.0), gain, color=LIGHT_GREY, alpha=0.6, lw=0.0)
        axes.annotate(
            f"disk {disk:g}", (-180.0, gain.max()), fontsize=7.5, color=GREY,
            ha="center", va="bottom",
        )  # fmt: skip
    axes.plot(-180.0, 0.0, "+", color=BLACK, ms=9.0)
    for index, name in enumerate(CHANNELS):
        for ratios, width, alpha, line, words in (
            (study.model_ratios, 3.5, 0.3, "-", None),
            (study.flown_ratios, 1.4, 1.0, "-", name),
        ):
            phase, gain = _nichols(ratios[:, index])
            axes.plot(phase, gain, line, color=COLOURS[name], lw=width, alpha=alpha, label=words)
    axes.plot([], [], color=GREY, lw=3.5, alpha=0.4, label="model")
    axes.set(
        xlim=PHASES, ylim=GAINS, xticks=np.arange(PHASES[0], PHASES[1] + 1.0, 45.0),
        xlabel="phase [deg]", ylabel="gain [dB]", title="Still air, flown with all estimators",
    )  # fmt: skip
    axes.legend(loc="lower right")


def _draw_delays(axes: Axes, study: MarginStudy) -> None:
    """Delay margin of turn and path around the orbit, or of all channels in still air."""
    asked = study.configuration.controller.delay_margin_min
    for name in CHANNELS:
        delays = [each.channels[name].delay_s for each in study.in_wind]
        if delays:
            axes.plot(np.degrees(study.azimuths), delays, color=COLOURS[name], marker=".")
        axes.axhline(study.flown.channels[name].delay_s, color=COLOURS[name], lw=0.8, ls=":")
    axes.axhline(asked, color=BLACK, lw=1.0, ls=(0, (5, 2.5)))
    axes.annotate(
        "asked", (1.0, asked), xycoords=("axes fraction", "data"), fontsize=8.0,
        ha="right", va="top", color=BLACK,
    )  # fmt: skip
    speed = np.hypot(*study.drift[:2])
    axes.set(
        xlim=(0.0, 360.0), xticks=np.arange(0.0, 361.0, 90.0), yscale="log", ylim=DELAYS,
        xlabel="azimuth on the orbit, from east [deg]", ylabel="delay margin [s]",
        title=f"Drift of {speed:.1f} m/s, frozen (dotted: still air)",
    )  # fmt: skip
    axes.set_yticks(DELAY_TICKS, [f"{tick:g}" for tick in DELAY_TICKS])
    axes.yaxis.set_minor_locator(NullLocator())


def _nichols(ratio: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Phase in [deg], continuous and within a turn of -180 deg at its middle, and gain in [dB]."""
    phase = np.degrees(np.unwrap(np.angle(ratio)))
    crossover = int(np.argmin(np.abs(np.log(np.abs(ratio)))))
    phase -= 360.0 * np.ceil(phase[crossover] / 360.0)
    return phase, 20.0 * np.log10(np.abs(ratio))
