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

r"""Margins of the loop that flies, measured in still air on the orbit, and of its model.

The controller with all its estimators flies the plant twice: undisturbed, and with an impulse added
to the commands of one channel for one control period, of which it does not know. The commands of
both flights differ by the answer of the loop. With the impulse's size D in channel i and the
control period T,

.. math::

    S_{ji}(e^{i\omega T}) = \delta_{ji} + \frac{1}{D} \sum_k \Delta u_{j,k} e^{-i\omega T k},
    \qquad L = S^{-1} - I.

This assumes nothing of the controller but that its answer to a small disturbance is linear, does
not depend on the time, and dies away.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.margins.loop_margins import (
    CHANNELS,
    UNSTABLE,
    LoopMargins,
    disk_gain_db,
    disk_phase_deg,
    loop_margins,
    return_ratios,
)
from uav_tracking_mpc.margins.margin_check import shortfalls
from uav_tracking_mpc.margins.orbit_loop import OrbitLoop
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT_GREY,
    VERMILLION,
    drawing,
)
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import Disturbance, simulate
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.study import Study, plain

SETTLED = 60.0  # s after which a flight that begins on the orbit is steady
OBSERVED = 60.0  # s in which the answer to an impulse dies away
LATE, LEFT = 10.0, 0.05  # s, -: at the end, in which no more than this share of an answer is left
IMPULSES = np.array([0.1, 0.1, 1.0])  # rad/s, rad/s, m/s^2 during one control period
ROUNDING = 1e-6  # s, rounding of stamps


def disturbed(inputs: NDArray[np.float64], duration: float, time: float) -> NDArray[np.float64]:
    """What an impulse adds to (u_psi, u_chi, u_v) at a time, shape (3,).

    Args:
        inputs: While it lasts, shape (3,), in [rad/s], [rad/s] and [m/s^2].
        duration: In [s].
        time: Since the start in [s].
    """
    inside = -ROUNDING <= time - SETTLED < duration - ROUNDING
    return inputs if inside else np.zeros(3)


class FlownLoop(NamedTuple):
    """What flights have shown of the loop.

    Attributes:
        loop: L, shape (n, 3, 3), at the frequencies that were asked for.
        settled: Whether every answer has died away: else L means nothing.
    """

    loop: NDArray[Any]
    settled: bool


def in_still_air(configuration: Configuration) -> Configuration:
    """The configuration about a target that stands in still air, beginning on the orbit.

    Sensors have no noise; what else may be wrong with them or the aircraft stays. Commands come
    with every state, or every second, and so on: evenly.

    Args:
        configuration: Of a flight.
    """
    orbit, rate = configuration.controller.orbit, configuration.simulator.state_rate
    even = rate / math.ceil(rate / configuration.controller.control_rate - ROUNDING)
    return replace(
        configuration,
        controller=replace(configuration.controller, direction=orbit.direction, control_rate=even),
        simulator=replace(
            configuration.simulator,
            wind=(0.0, 0.0, 0.0),
            gust_intensity=0.0,
            position_noise=0.0,
            velocity_noise=0.0,
            attitude_noise=0.0,
            airspeed_noise=0.0,
            initial_position=(orbit.radius, 0.0, orbit.altitude),
            initial_heading=orbit.sense * math.pi / 2.0,
            initial_path_angle=0.0,
            initial_speed=orbit.speed,
        ),
        target=replace(
            configuration.target, motion="stationary", position=(0.0, 0.0, 0.0), noise=0.0
        ),
        mission=replace(
            configuration.mission, duration=SETTLED + OBSERVED, plant=configuration.simulator.plant
        ),
    )


def flown_loops(
    configuration: Configuration,
    frequency: NDArray[np.float64],
    sizes: Sequence[float] = (1.0,),
    workers: int | None = None,
    show: bool = True,
) -> list[FlownLoop]:
    """Loop of a configuration by flights in still air, one for each size of the impulses.

    Args:
        configuration: Of the flights.
        frequency: Shape (n,), in [rad/s].
        sizes: Of the impulses, as shares of :data:`IMPULSES` [-].
        workers: Processes; all cores by default.
        show: Progress bar on stderr.
    """
    still = in_still_air(configuration)
    period = 1.0 / still.controller.control_rate
    impulses = [np.zeros(3), *(size * impulse for size in sizes for impulse in np.diag(IMPULSES))]
    tasks = [(still, partial(disturbed, impulse, period)) for impulse in impulses]
    steady, *answers = parallel_map(_commands, tasks, workers, "impulses", show)
    powers = np.exp(-1j * np.outer(frequency * period, np.arange(len(steady))))
    late, loops = round(LATE / period), []
    for size in sizes:
        sensitivity = np.tile(np.eye(3, dtype=complex), (len(frequency), 1, 1))
        settled = True
        for axis, impulse in enumerate(IMPULSES):
            change = (answers.pop(0) - steady) / (size * impulse)
            sensitivity[:, :, axis] += powers @ change
            left = np.abs(change[-late:, axis]).max()
            settled &= bool(left <= LEFT * np.abs(change[:, axis]).max())
        loops.append(FlownLoop(np.linalg.inv(sensitivity) - np.eye(3), settled))
    return loops


def _commands(configuration: Configuration, disturbance: Disturbance) -> NDArray[np.float64]:
    """Commands of a flight from the disturbance on, shape (n, 3)."""
    log = simulate(configuration, disturbance=disturbance)
    return log.inputs[log.command_time >= SETTLED - ROUNDING]


FREQUENCIES = 600  # of a response
AZIMUTHS = 24  # at which the orbit is frozen
# -, of the impulses, each half of the one before: a loop that is linear answers both alike. The
# estimate of the response may take an impulse for a gain, which is not linear.
SIZES = (1.0, 0.5, 0.25, 0.125)
ALIKE = 0.1  # -, of the sensitivity, by which two answers that are alike may differ


@dataclass(frozen=True)
class MarginStudy:
    """Margins of one configuration.

    Attributes:
        configuration: Whose they are, with its wind.
        flown: In still air, of the flights, with all estimators.
        flown_ratios: Return ratio of each channel, shape (n, 3), over the frequencies.
        nonlinearity: Greatest difference between the sensitivities that impulses and half of them
            give [-].
        model: In still air, of the model.
        model_ratios: As above, shape (n, 3).
        drift: Of the air as seen from the target, shape (3,), in [m/s].
        azimuths: At which the orbit in that drift was frozen, shape (m,), in [rad].
        in_wind: Of the model at each of them; none without drift.
    """

    configuration: Configuration
    flown: LoopMargins
    flown_ratios: NDArray[Any]
    nonlinearity: float
    model: LoopMargins
    model_ratios: NDArray[Any]
    drift: NDArray[np.float64]
    azimuths: NDArray[np.float64]
    in_wind: Sequence[LoopMargins]

    @property
    def worst(self) -> LoopMargins | None:
        """In wind, each channel and all at once where the disk margin is least; None without."""
        if not self.in_wind:
            return None
        channels = {
            name: min((each.channels[name] for each in self.in_wind), key=lambda m: m.disk)
            for name in CHANNELS
        }
        return LoopMargins(channels, min(each.disk for each in self.in_wind))

    @property
    def shortfalls(self) -> list[str]:
        """What is smaller than the configuration asks, in words."""
        judged = {"still air": self.flown, "in wind": self.worst}
        return [
            f"{where}, {words}"
            for where, margins in judged.items()
            if margins is not None
            for words in shortfalls(margins, self.configuration.controller)
        ]


def margin_study(
    configuration: Configuration, workers: int | None = None, show: bool = True
) -> MarginStudy:
    """Margins of a configuration; its wind and target say what the drift is.

    Args:
        configuration: Of a flight.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.

    Raises:
        ParameterError: There is no such law, the parameters cannot be flown, the controller has no
            answer on the orbit, or what it answers there is not linear.
    """
    simulator = configuration.simulator
    plant = Response(
        np.array(simulator.rate_lag),
        np.array(simulator.dead_time),
        np.array(simulator.command_gain),
    )
    drift = drift_of(configuration)
    near = OrbitLoop(configuration.controller)
    still = near.orbit_in(np.zeros(3))
    by_model = near.loop(still, plant)
    frequency = by_model.frequencies(FREQUENCIES)
    flown, nonlinearity = linear_loop(configuration, frequency, workers, show)
    count = AZIMUTHS if np.any(drift) else 0
    azimuths = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    return MarginStudy(
        configuration=configuration,
        flown=loop_margins(frequency, flown.loop) if flown.settled else UNSTABLE,
        flown_ratios=return_ratios(flown.loop),
        nonlinearity=nonlinearity,
        model=near.margins(still, plant),
        model_ratios=return_ratios(by_model.response(frequency)),
        drift=drift,
        azimuths=azimuths,
        in_wind=[near.margins(near.orbit_in(drift, phi), plant) for phi in azimuths.tolist()],
    )


def linear_loop(
    configuration: Configuration, frequency: NDArray[np.float64], workers: int | None, show: bool
) -> tuple[FlownLoop, float]:
    """The loop by the largest impulses whose halves show the same loop.

    Args:
        configuration: Of the flights.
        frequency: Shape (n,), in [rad/s].
        workers: Processes; all cores by default.
        show: Progress bar on stderr.

    Returns:
        The loop, and the greatest difference between the sensitivities by impulses and by their
        halves [-].

    Raises:
        ParameterError: The smallest impulses do not show the same loop either.
    """
    whole, half = flown_loops(configuration, frequency, SIZES[:2], workers, show)
    for smaller in (*SIZES[2:], None):
        change = sensitivities(whole.loop) - sensitivities(half.loop)
        difference = float(np.max(np.abs(change)))
        # Where neither answer dies away the loop is not stable, and there is nothing to compare.
        if difference <= ALIKE or not (whole.settled or half.settled):
            return whole, difference
        if smaller is not None:
            whole, (half,) = half, flown_loops(configuration, frequency, (smaller,), workers, show)
    raise ParameterError(
        f"the loop has no margins: impulses of {SIZES[-2]:g} and {SIZES[-1]:g} of the usual size "
        f"show sensitivities that differ by {difference:.2g}, must be at most {ALIKE:g}"
    )


def drift_of(configuration: Configuration) -> NDArray[np.float64]:
    """Steady wind less the target's velocity at the start, shape (3,), in [m/s].

    Args:
        configuration: Of a flight.
    """
    wind = np.array(configuration.simulator.wind)
    return np.asarray(wind - motion_of(configuration.target).velocity(0.0))


def sensitivities(loop: NDArray[Any]) -> NDArray[Any]:
    """S_ii of each channel, shape (n, 3).

    Args:
        loop: L, shape (n, 3, 3).
    """
    return 1.0 / (1.0 + return_ratios(loop))


def as_json(study: MarginStudy) -> dict[str, Any]:
    """The margins as one object for JSON; those without end are null."""
    worst, asked = study.worst, study.configuration.controller
    content = {
        "config": study.configuration.name,
        **_margins(study.flown),
        "nonlinearity": study.nonlinearity,
        "model": _margins(study.model),
        "wind": None,
        "asked": {"delay_s": asked.delay_margin_min, "gain_db": asked.gain_margin_min},
        "shortfalls": study.shortfalls,
    }
    if worst is not None:
        least = int(np.argmin([each.disk for each in study.in_wind]))
        content["wind"] = {
            "drift_mps": study.drift.tolist(),
            "worst_phase_deg": math.degrees(study.azimuths[least]),
            **_margins(worst),
        }
    return dict(plain(content))


def _margins(margins: LoopMargins) -> dict[str, Any]:
    return {
        "channels": {name: each._asdict() for name, each in margins.channels.items()},
        "disk": margins.disk,
        "disk_gain_db": disk_gain_db(margins.disk),
        "disk_phase_deg": disk_phase_deg(margins.disk),
    }


COLUMNS = ("gain up [dB]", "gain down [dB]", "phase [deg]", "delay [s]", "disk")
CAPTION = (
    "Margin of each channel at the plant's input, beyond the lag, dead time and gain given to the "
    "controller, with the other channels closed; all: every channel at once, gain and phase of the "
    "disk margin. flown: the controller with its estimators, by impulses; model: linearised; in "
    "wind: the model, frozen where the disk margin is smallest."
)


def margin_table(study: MarginStudy) -> Table:
    """One row for each channel and one for all at once."""
    parts = {"still air, flown": study.flown, "still air, model": study.model}
    if study.worst is not None:
        parts["in wind, worst"] = study.worst
    rows = [
        [words if index == 0 else "", *cells]
        for words, margins in parts.items()
        for index, cells in enumerate(_rows(margins))
    ]
    return Table(("loop", "channel", *COLUMNS), rows, numeric=COLUMNS, caption=CAPTION)


def _rows(margins: LoopMargins) -> list[list[str]]:
    gain, phase = disk_gain_db(margins.disk), disk_phase_deg(margins.disk)
    return [
        *(
            [
                name,
                _number(channel.gain_increase_db, 1),
                _number(channel.gain_reduction_db, 1),
                _number(channel.phase_deg, 0),
                _number(channel.delay_s, 2),
                _number(channel.disk, 2),
            ]
            for name, channel in margins.channels.items()
        ),
        ["all", *[_number(gain, 1)] * 2, _number(phase, 0), "", _number(margins.disk, 2)],
    ]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "any"


SIZE = (9.5, 4.4)  # inch, of the figure
COLOURS = dict(zip(CHANNELS, (BLUE, VERMILLION, GREEN), strict=True))
DISKS = (0.5, 1.0)  # -, of the sensitivity that are drawn
DELAYS, DELAY_TICKS = (0.1, 10.0), (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # s, that are drawn
PHASES, GAINS = (-360.0, 0.0), (-40.0, 40.0)  # deg, dB, that are drawn


def margin_figure(study: MarginStudy) -> Figure:
    r"""A Nichols chart of each channel's return ratio, and the margins around the orbit.

    A disk of size alpha about the critical point is left free by l where
    :math:`|(1 - l) / (1 + l)| < 2 / \alpha`; its edge is :math:`l = (1 - m) / (1 + m)` with
    :math:`m = (2 / \alpha) e^{i\vartheta}`.

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
