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

r"""The loop that flies, measured in still air on the orbit.

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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.parallel import parallel_map

SETTLED = 60.0  # s after which a flight that begins on the orbit is steady
OBSERVED = 60.0  # s in which the answer to an impulse dies away
LATE, LEFT = 10.0, 0.05  # s at the end, in which no more than this share of an answer is left
IMPULSES = np.array([0.1, 0.1, 1.0])  # rad/s, rad/s, m/s^2 during one control period
ROUNDING = 1e-6  # s


@dataclass(frozen=True)
class Impulse:
    """A disturbance of one control period.

    Attributes:
        inputs: Added to (u_psi, u_chi, u_v), shape (3,), in [rad/s], [rad/s] and [m/s^2].
        duration: In [s].
    """

    inputs: NDArray[np.float64]
    duration: float

    def __call__(self, time: float) -> NDArray[np.float64]:
        """What is added at a time, shape (3,).

        Args:
            time: Since the start in [s].
        """
        inside = -ROUNDING <= time - SETTLED < self.duration - ROUNDING
        return self.inputs if inside else np.zeros(3)


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

    Sensors have no noise; what else may be wrong with them or the aircraft stays.

    Args:
        configuration: Of a flight.
    """
    orbit = configuration.controller.orbit
    sense = 1.0 if orbit.direction == COUNTER_CLOCKWISE else -1.0
    return replace(
        configuration,
        controller=replace(configuration.controller, direction=orbit.direction),
        simulator=replace(
            configuration.simulator,
            wind=(0.0, 0.0, 0.0),
            gust_intensity=0.0,
            position_noise=0.0,
            velocity_noise=0.0,
            attitude_noise=0.0,
            airspeed_noise=0.0,
            initial_position=(orbit.radius, 0.0, orbit.altitude),
            initial_heading=sense * math.pi / 2.0,
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
    disturbances = [
        Impulse(size * impulse, period) for size in sizes for impulse in np.diag(IMPULSES)
    ]
    undisturbed = Impulse(np.zeros(3), period)
    tasks = [(still, each) for each in (undisturbed, *disturbances)]
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


def _commands(task: tuple[Configuration, Impulse]) -> NDArray[np.float64]:
    """Commands of a flight from the disturbance on, shape (n, 3)."""
    configuration, disturbance = task
    log = simulate(configuration, disturbance=disturbance)
    return log.inputs[log.command_time >= SETTLED - ROUNDING]
