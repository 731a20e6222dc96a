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

"""Values of a recorded flight that were sent beside its states and commands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.simulation.flight_log import Latency, LinkFigures


def airspeeds(
    flown: Sequence[tuple[int, Measurement]], measured: Sequence[tuple[int, float]]
) -> NDArray[np.float64]:
    """Airspeed at each state, shape (n,), in [m/s]; of still air where none was measured.

    Args:
        flown: Stamp in [ns] and motion of each state.
        measured: Stamp in [ns] and airspeed in [m/s] of each air velocity.
    """
    if not measured:
        return np.array([np.linalg.norm(motion.ground_velocity) for _, motion in flown])
    stamps, speeds = zip(*sorted(measured), strict=True)
    first = stamps[0]  # differences keep their nanoseconds as floats
    return np.interp(
        [stamp - first for stamp, _ in flown], [stamp - first for stamp in stamps], speeds
    )


def latency(
    states: Sequence[tuple[int, int]], commands: Sequence[tuple[int, int]]
) -> Latency | None:
    """From a state on the wire to the command computed from it, as the recorder heard them.

    A command bears the stamp of its state. Simulated stamps are not wall time: the times at which
    the recorder heard state and command are compared instead.

    Args:
        states: Stamp in [ns] of each state and wall time in [ns] at which it was heard.
        commands: The same of each command.

    Returns:
        The figures in [us]; None where no command answers a recorded state.
    """
    arrival = dict(states)
    delays = [(time - arrival[stamp]) * 1e-3 for stamp, time in commands if stamp in arrival]
    if not delays:
        return None
    median, p99 = np.percentile(delays, [50.0, 99.0])
    return Latency(median=float(median), p99=float(p99), max=float(max(delays)))


def beside_commands(
    sent: Sequence[int], values: Sequence[tuple[int, float]]
) -> NDArray[np.float64]:
    """Values in the order of the commands: each was sent right after its command.

    Args:
        sent: Wall time in [ns] at which each command was heard.
        values: Wall time in [ns] at which each value was heard, and the value.

    Returns:
        One value a command, shape (n,); nan where none was heard.
    """
    beside = np.full(len(sent), np.nan)
    for time, value in values:
        index = int(np.searchsorted(sent, time, side="right")) - 1
        if index >= 0:
            beside[index] = value
    return beside


def link_figures(link: dict[str, str]) -> LinkFigures:
    """What a link measured.

    Args:
        link: The last values of its diagnostics, by name.
    """
    return LinkFigures(
        dialect=link["dialect"],
        rate=float(link.get("rate [Hz]", "nan")),
        latency=float(link.get("latency median [ms]", "nan")),
        latency_p99=float(link.get("latency p99 [ms]", "nan")),
        lost=int(link.get("messages lost", 0)),
        refused=int(link.get("commands refused", 0)) + int(link.get("plans refused", 0)),
    )
