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

"""The table of margins."""

from __future__ import annotations

import math

from uav_tracking_mpc.control.loop_margins import LoopMargins, disk_gain_db, disk_phase_deg
from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.studies.margins.margin_study import MarginStudy

COLUMNS = ("gain up [dB]", "gain down [dB]", "phase [deg]", "delay [s]", "disk")
CAPTION = (
    "How much more each channel bears at the plant's input beyond what the controller is told, the "
    "others as they are; all: every channel at once, gain and phase of the disk margin. Flown: the "
    "controller with its estimators, by impulses; model: linearised; in wind: the model, frozen "
    "where the disk margin is least."
)


def margin_table(study: MarginStudy) -> Table:
    """One row for each channel and one for all at once.

    Args:
        study: Of a configuration.
    """
    parts = {"still air, flown": study.flown, "still air, model": study.model}
    if study.worst is not None:
        parts["in wind, worst"] = study.worst
    rows = [
        [words if index == 0 else "", *cells]
        for words, margins in parts.items()
        for index, cells in enumerate(_rows(margins))
    ]
    return Table(("", "channel", *COLUMNS), rows, numeric=COLUMNS, caption=CAPTION)


def _rows(margins: LoopMargins) -> list[list[str]]:
    rows = [
        [
            name,
            _number(channel.gain_increase_db, 1),
            _number(channel.gain_reduction_db, 1),
            _number(channel.phase_deg, 0),
            _number(channel.delay_s, 2),
            _number(channel.disk, 2),
        ]
        for name, channel in margins.channels.items()
    ]
    gain = _number(disk_gain_db(margins.disk), 1)
    phase = _number(disk_phase_deg(margins.disk), 0)
    return [*rows, ["all", gain, gain, phase, "", _number(margins.disk, 2)]]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "any"
