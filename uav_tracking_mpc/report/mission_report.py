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

"""A flight as a moving scene that a page can hold: what draws it is above the report."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uav_tracking_mpc.report.atomic_write import json_text, write_atomically, write_json
from uav_tracking_mpc.report.figure_style import save_figure
from uav_tracking_mpc.report.metrics import (
    BAND_UNITS,
    fallbacks,
    metrics,
    quantity,
    range_offset_finding,
    settled,
    sound,
    verdict,
)
from uav_tracking_mpc.report.pages import ICON_ADDRESS, embedded, render
from uav_tracking_mpc.report.time_panels import (
    DECADES,
    conditions_figure,
    has_conditions,
    states_figure,
)
from uav_tracking_mpc.report.trajectory import trajectory_figure
from uav_tracking_mpc.simulation.flight_log import FlightLog


@dataclass(frozen=True)
class Replay:
    """A scene that plays by itself in a browser.

    Attributes:
        html: A whole page that asks for nothing from elsewhere.
        pace: Time of the flight over time of the replay [-].
        frames: Pictures of the flight in it.
    """

    html: str
    pace: float
    frames: int


logger = logging.getLogger(__name__)

TEMPLATE = "mission_report.html.j2"
RecordScene = Callable[[FlightLog], Replay | None]


def write_report(
    log: FlightLog, output: Path, record_scene: RecordScene | None = None
) -> dict[str, Any]:
    """Write ``metrics.json``, ``trajectory.png``, ``states.png`` and ``report.html``.

    Where there is more to a flight than the paper's point mass in still air, ``conditions.png``
    shows it: limits, wind, the target's speed, fallback modes.

    The numbers come first, so that they stand even where a figure cannot be drawn. Each file
    replaces an older one as a whole; nothing is written outside the folder.

    Args:
        log: Record of the flight.
        output: Folder, made if it is not there.
        record_scene: Makes the moving scene of the page; it may answer None. Where it raises
            anything, the page says so in its place.

    Returns:
        The content of ``metrics.json``.

    Raises:
        OSError: The folder cannot be made or written to; the message names it and says why.
    """
    output = Path(output)
    numbers = metrics(log)
    try:
        output.mkdir(parents=True, exist_ok=True)
        write_json(output / "metrics.json", numbers)
        trajectory = save_figure(trajectory_figure(log), output / "trajectory.png")
        states = save_figure(states_figure(log), output / "states.png")
        conditions = (
            save_figure(conditions_figure(log), output / "conditions.png")
            if has_conditions(log)
            else None
        )
        replay, failure = _recorded(log, record_scene)
        page = render_page(log, numbers, trajectory, states, conditions, replay, failure)
        write_atomically(output / "report.html", page.encode())
    except OSError as error:
        reason = error.strerror or str(error)
        raise OSError(error.errno, f"cannot write the report: {reason}", str(output)) from error
    return numbers


def _recorded(log: FlightLog, record_scene: RecordScene | None) -> tuple[Replay | None, str]:
    """The moving scene, and why there is none where that failed: the report stands without it."""
    try:
        return None if record_scene is None else record_scene(log), ""
    except Exception as error:  # drawn by what users add, too
        logger.exception("the report is without its moving scene")
        return None, f"{type(error).__name__}: {error}"


def render_page(
    log: FlightLog,
    numbers: dict[str, Any],
    trajectory: bytes,
    states: bytes,
    conditions: bytes | None = None,
    replay: Replay | None = None,
    scene_failure: str = "",
) -> str:
    """The page as HTML, with style and pictures inside.

    Args:
        log: Record of the flight.
        numbers: Its metrics.
        trajectory: PNG file of the flight in space.
        states: PNG file of states and inputs over time.
        conditions: PNG file of limits, air, target and modes over time; None where there is none.
        replay: The moving scene; None where there is none.
        scene_failure: Why there is none where it could not be made; else empty.
    """
    return render(
        "uav_tracking_mpc.report",
        TEMPLATE,
        {"quantity": quantity},
        log=log,
        icon=ICON_ADDRESS,
        numbers=numbers,
        numbers_json=json_text(numbers),
        units=BAND_UNITS,
        decades=DECADES,
        settled=settled(numbers),
        sound=sound(numbers),
        verdict=verdict(numbers),
        offset=range_offset_finding(log),
        trajectory=embedded(trajectory),
        states=embedded(states),
        conditions=None if conditions is None else embedded(conditions),
        replay=replay,
        scene_failure=scene_failure,
        fallbacks=fallbacks(log),
        fell_back=sum(not each.mode.nominal for each in log.modes),
    )
