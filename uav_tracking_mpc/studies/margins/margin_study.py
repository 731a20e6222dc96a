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

"""Margins of a configuration: flown in still air, by the model in still air and in wind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.loop_margins import (
    CHANNELS,
    UNSTABLE,
    ChannelMargins,
    LoopMargins,
    disk_gain_db,
    disk_phase_deg,
    loop_margins,
    return_ratios,
)
from uav_tracking_mpc.control.margin_check import shortfalls
from uav_tracking_mpc.control.orbit_loop import OrbitLoop
from uav_tracking_mpc.dynamics.response import Response
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.margins.flown_loop import flown_loops

FREQUENCIES = 600
AZIMUTHS = 24
SIZES = (1.0, 0.5)  # of the impulses: a loop that is linear answers both alike


@dataclass(frozen=True)
class MarginStudy:
    """Margins of one configuration.

    Attributes:
        configuration: Whose they are, with its wind.
        frequency: Shape (n,), in [rad/s].
        flown: In still air, of the flights, with all estimators.
        flown_ratios: Return ratio of each channel, shape (n, 3).
        nonlinearity: Greatest difference between the sensitivities that whole and half impulses
            give [-].
        model: In still air, of the model.
        model_ratios: As above, shape (n, 3).
        drift: Of the air as seen from the target, shape (3,), in [m/s].
        azimuths: At which the orbit in that drift was frozen, shape (m,), in [rad].
        in_wind: Of the model at each of them; none without drift.
    """

    configuration: Configuration
    frequency: NDArray[np.float64]
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
        asked, worst = self.configuration.controller, self.worst
        found = [f"still air, {words}" for words in shortfalls(self.flown, asked)]
        if worst is not None:
            found += [f"in wind, {words}" for words in shortfalls(worst, asked)]
        return found


def margin_study(
    configuration: Configuration, workers: int | None = None, show: bool = True
) -> MarginStudy:
    """Margins of a configuration; its wind and target say what the drift is.

    Args:
        configuration: Of a flight.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.

    Raises:
        ParameterError: There is no such law, or the parameters cannot be flown.
        ArithmeticError: The controller has no answer on the orbit.
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
    whole, half = flown_loops(configuration, frequency, SIZES, workers, show)
    response = by_model.response(frequency)
    azimuths = np.linspace(0.0, 2.0 * math.pi, AZIMUTHS, endpoint=False)
    if not np.any(drift):
        azimuths = azimuths[:0]
    change = sensitivities(whole.loop) - sensitivities(half.loop)
    return MarginStudy(
        configuration=configuration,
        frequency=frequency,
        flown=loop_margins(frequency, whole.loop) if whole.settled else UNSTABLE,
        flown_ratios=return_ratios(whole.loop),
        nonlinearity=float(np.max(np.abs(change))),
        model=near.margins(still, plant),
        model_ratios=return_ratios(response),
        drift=drift,
        azimuths=azimuths,
        in_wind=[near.margins(near.orbit_in(drift, phi), plant) for phi in azimuths.tolist()],
    )


def drift_of(configuration: Configuration) -> NDArray[np.float64]:
    """Steady wind less the target's velocity at the start, shape (3,), in [m/s].

    Args:
        configuration: Of a flight.
    """
    target = motion_of(configuration.target).velocity(0.0)
    return np.array(configuration.simulator.wind) - target


def sensitivities(loop: NDArray[Any]) -> NDArray[Any]:
    """S_ii of each channel, shape (n, 3).

    Args:
        loop: L, shape (n, 3, 3).
    """
    return 1.0 / (1.0 + return_ratios(loop))


def as_json(study: MarginStudy) -> dict[str, Any]:
    """The margins as one object for JSON; those without end are null.

    Args:
        study: Of a configuration.
    """
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
    return content


def _margins(margins: LoopMargins) -> dict[str, Any]:
    return {
        "channels": {name: _channel(each) for name, each in margins.channels.items()},
        "disk": _finite(margins.disk),
        "disk_gain_db": _finite(disk_gain_db(margins.disk)),
        "disk_phase_deg": _finite(disk_phase_deg(margins.disk)),
    }


def _channel(margins: ChannelMargins) -> dict[str, float | None]:
    return {name: _finite(value) for name, value in margins._asdict().items()}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
