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

"""What was identified, for people: a table, and the parameters to paste."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.settings.parameter_file import parameter_file
from uav_tracking_mpc.studies.identification.channel_record import (
    CHANNELS,
    PATH,
    SPEED,
    TURN,
    UNITS,
)
from uav_tracking_mpc.studies.identification.identification import ChannelIdentification
from uav_tracking_mpc.studies.identification.profile_intervals import CONFIDENCE, Estimate

HEADINGS = ("channel", "lag [s]", "dead time [s]", "sum [s]", "gain [-]", "flown", "limits seen")
# Parameters of a channel's limits, of controller and simulator; of a turn the bank.
LIMIT_NAMES = {
    TURN: ("bank_max",),
    PATH: ("pitch_rate_max",),
    SPEED: ("acceleration_min", "acceleration_max"),
}


def identification_table(found: Sequence[ChannelIdentification]) -> Table:
    """One row a channel.

    Args:
        found: Of a flight.
    """
    return Table(
        HEADINGS,
        [_row(channel) for channel in found],
        title="How the aircraft answers commands",
        caption=f"In brackets: {CONFIDENCE:.0%} confidence intervals.",
    )


def _row(channel: ChannelIdentification) -> tuple[str, ...]:
    lag, dead_time, total, gain = channel.estimates
    least, greatest = channel.largest
    flown = f"{least:.2f} to {greatest:.2f} {UNITS[channel.name]}"
    bank = channel.largest_bank
    if bank is not None:
        flown += f", bank {math.degrees(bank):.0f} deg"
    limits = [_limit(channel.name, value) for value in channel.observed_limits if value is not None]
    name = channel.name if channel.sure else f"{channel.name} (not sure)"
    figures = (_words(figure) for figure in (lag, dead_time, total, gain))
    return name, *figures, flown, ", ".join(limits) or "none"


def _words(estimate: Estimate) -> str:
    value, lower, upper = estimate
    return f"{value:.3f} [{lower:.3f}, {upper:.3f}]"


def _limit(name: str, value: float) -> str:
    if name == TURN:
        return f"bank {math.degrees(value):.0f} deg"
    return f"{value:.2f} {UNITS[name]}"


def parameters_to_paste(found: Sequence[ChannelIdentification]) -> str:
    """Sections of a configuration with what was identified, as YAML.

    A channel that was not identified keeps a comment; its numbers are placeholders.

    Args:
        found: Of a flight.
    """
    known = {channel.name: channel for channel in found}
    lag = [_rounded(known, name, "lag", 0.0) for name in CHANNELS]
    dead_time = [_rounded(known, name, "dead_time", 0.0) for name in CHANNELS]
    gain = [_rounded(known, name, "gain", 1.0) for name in CHANNELS]
    limits = {key: value for one in found for key, value in _limits_to_paste(one).items()}
    controller = {"rate_lag": lag, "dead_time": dead_time, **limits}
    # Lists of its own: YAML would refer to one that stands above.
    simulator = {"rate_lag": [*lag], "dead_time": [*dead_time], "command_gain": gain, **limits}
    comments = [
        f"# {name}: {'not sure, excite it more' if name in known else 'not measured'}\n"
        for name in CHANNELS
        if name not in known or not known[name].sure
    ]
    return "".join(comments) + parameter_file(
        {"nmpc_controller": controller, "uav_simulator": simulator}
    )


def _rounded(
    known: dict[str, ChannelIdentification], name: str, figure: str, otherwise: float
) -> float:
    if name not in known:
        return otherwise
    return round(getattr(known[name].estimates, figure).value, 3)


def _limits_to_paste(channel: ChannelIdentification) -> dict[str, float]:
    """Limits that showed, by parameter; of two sides of a symmetric one the smaller."""
    lower, upper = channel.observed_limits
    names = LIMIT_NAMES[channel.name]
    if len(names) == 2:
        pairs = zip(names, (lower, upper), strict=True)
        return {name: round(value, 3) for name, value in pairs if value is not None}
    sides = [abs(value) for value in (lower, upper) if value is not None]
    return {names[0]: round(min(sides), 3)} if sides else {}
