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

"""All channels of a flight: what they do, how sure that is, and what was seen of their limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.studies.identification.bag_record import read_bag_record
from uav_tracking_mpc.studies.identification.channel_fit import ChannelFit
from uav_tracking_mpc.studies.identification.channel_record import TURN, ChannelRecord
from uav_tracking_mpc.studies.identification.csv_record import read_csv_record
from uav_tracking_mpc.studies.identification.flight_record import FlightRecord, RecordError
from uav_tracking_mpc.studies.identification.profile_intervals import (
    CONFIDENCE,
    Estimates,
    estimates,
)
from uav_tracking_mpc.studies.identification.saturation import Limits, limited_fit

# Half of the interval of lag plus dead time up to which a channel counts as identified.
SURE, SURE_SHARE = 0.1, 0.25  # s, and share of the value


@dataclass(frozen=True)
class ChannelIdentification:
    """What a flight says of one channel.

    Attributes:
        name: Of the channel.
        estimates: Lag, dead time, their sum, and gain.
        fit: Where they come from.
        limits: What the answer shows of its limits.
    """

    name: str
    estimates: Estimates
    fit: ChannelFit
    limits: Limits

    @property
    def sure(self) -> bool:
        """Whether the record tells enough to use the figures."""
        value, lower, upper = self.estimates.total
        return 0.5 * (upper - lower) <= max(SURE, SURE_SHARE * value)

    @property
    def largest(self) -> tuple[float, float]:
        """Least and greatest rate flown in [rad/s] or [m/s^2]."""
        rate = self.fit.flown_rate()
        return float(np.min(rate)), float(np.max(rate))

    @property
    def observed_limits(self) -> tuple[float | None, float | None]:
        """Limits of what is flown in [rad/s], [m/s^2] or, of a turn, bank [rad]; None: unseen."""
        gain = self.estimates.gain.value
        found = [float(gain * limit) if math.isfinite(limit) else None for limit in self.limits]
        if self.name == TURN:
            found = [None if tangent is None else math.atan(tangent) for tangent in found]
        return found[0], found[1]

    @property
    def largest_bank(self) -> float | None:
        """Greatest bank of the turns flown in [rad]; None of other channels."""
        record = self.fit.record
        if self.name != TURN:
            return None
        lever = np.interp(record.state.time, record.demand.time, record.leverage)
        return float(np.max(np.arctan(np.abs(self.fit.flown_rate() * lever))))

    def as_json(self) -> dict[str, Any]:
        """Plain values, in SI units and radians."""
        figures = {
            f"{name}{unit}": dict(zip(("value", "lower", "upper"), estimate, strict=True))
            for name, unit, estimate in zip(
                self.estimates._fields, ("_s", "_s", "_s", ""), self.estimates, strict=True
            )
        }
        return {
            **figures,
            "sure": self.sure,
            "largest": list(self.largest),
            "largest_bank_rad": self.largest_bank,
            "limits_observed": list(self.observed_limits),
            "noise": self.fit.noise[0].deviation,
            "noise_order": len(self.fit.noise[0].polynomial) - 1,
            "samples": self.fit.count,
        }


def read_record(path: Path) -> FlightRecord:
    """Read a flight: CSV by its ending, else a bag.

    Args:
        path: File, or folder of a bag.

    Raises:
        ParameterError: It does not hold what is needed.
        OSError: It is not there, or cannot be read.
    """
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist")
    try:
        return read_csv_record(path) if path.suffix == ".csv" else read_bag_record(path)
    except RecordError as error:
        raise ParameterError(str(error)) from error


def identify(channels: Iterable[ChannelRecord]) -> list[ChannelIdentification]:
    """Identify channels, each by itself.

    Args:
        channels: Of a flight.
    """
    return [_identified(record) for record in channels]


def _identified(record: ChannelRecord) -> ChannelIdentification:
    fit, limits = limited_fit(record)
    return ChannelIdentification(record.name, estimates(fit), fit, limits)


def identify_flight(path: Path) -> list[ChannelIdentification]:
    """Identify every channel that a file holds.

    Args:
        path: File, or folder of a bag.

    Raises:
        ParameterError: It does not hold what is needed.
        OSError: It is not there, or cannot be read.
    """
    record = read_record(path)
    try:
        channels = record.channels()
    except RecordError as error:
        raise ParameterError(f"{path}: {error}") from error
    return identify(channels)


def identification(path: Path, found: Sequence[ChannelIdentification]) -> dict[str, Any]:
    """What was found as plain values.

    Args:
        path: Of the record.
        found: In it.
    """
    return {
        "record": str(path),
        "confidence": CONFIDENCE,
        "channels": {channel.name: channel.as_json() for channel in found},
    }
