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

"""What each flight of a campaign meets."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration, Sections, configuration_of
from uav_tracking_mpc.studies.campaign.campaign_file import ALL, ONE, Campaign, Group
from uav_tracking_mpc.studies.campaign.uncertain_inputs import read, write

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class PlannedFlight:
    """What a flight meets.

    Attributes:
        number: Of the flight.
        group: Name of its group.
        error: Names of the errors drawn, joined by ``+``; empty for none.
        values: Of all inputs that may differ between flights, by key.
        sections: The parameters, without the law.
    """

    number: int
    group: str
    error: str
    values: dict[str, Any]
    sections: Sections

    def configuration(self, law: str) -> Configuration:
        """Parameters of the flight by a law.

        Args:
            law: Name of the law, or ``path.py:Class``.

        Raises:
            ParameterError: They are not allowed.
        """
        sections = {name: dict(values) for name, values in self.sections.items()}
        sections["nmpc_controller"]["law"] = law
        return configuration_of(flight_name(self.number, law), sections)


def flight_name(number: int, law: str) -> str:
    """Name of a flight, of its file too.

    Args:
        number: Of the flight.
        law: Name of the law, or ``path.py:Class``.
    """
    return f"flight_{number:06d}_{law.rsplit(':', 1)[-1]}"


def planned(campaign: Campaign, number: int) -> PlannedFlight:
    """What a flight meets.

    Args:
        campaign: That it belongs to.
        number: Of the flight, from 0 to ``campaign.total - 1``.
    """
    point, draw = divmod(number, campaign.flights)
    values = {
        key: each.draw(_stream(campaign, draw, key))
        for key, each in campaign.draw.items()
        if not each.swept
    }
    for key, swept in campaign.swept.items():
        point, index = divmod(point, len(swept))
        values[key] = swept[index]
    sections: Sections = {name: dict(them) for name, them in campaign.base.sections.items()}
    gusts, target = np.random.SeedSequence([campaign.seed, draw]).generate_state(2).tolist()
    sections["uav_simulator"]["seed"] = gusts >> 1  # the parameter takes 31 bits
    sections["target_publisher"]["seed"] = target >> 1
    write(sections, values)
    group, rank = _group_of(campaign, draw)
    names = _errors_of(campaign, group, rank)
    mistaken: dict[str, Any] = {}
    for name in names:
        for key, each in campaign.errors[name].items():
            neutral = mistaken[key] if key in mistaken else read(sections, key)
            random = _stream(campaign, draw, f"{name}/{key}")
            mistaken[key] = each.draw_within(random, neutral, group.range)
    write(sections, mistaken)
    effective = {
        key: mistaken[key] if key in mistaken else values.get(key, read(sections, key))
        for key in campaign.inputs
    }
    return PlannedFlight(number, group.name, "+".join(names), effective, sections)


def check_flights(campaign: Campaign, numbers: Sequence[int]) -> None:
    """Whether flights can be flown as they were drawn.

    Args:
        campaign: That they belong to.
        numbers: Of the flights.

    Raises:
        ParameterError: One cannot; the message says which.
    """
    for number in numbers:
        try:
            flown = planned(campaign, number).configuration(campaign.laws[0])
        except ParameterError as error:
            raise ParameterError(f"campaign {campaign.name}, flight {number}: {error}") from error
        after, duration = campaign.settled_after, flown.mission.duration
        if after is not None and after >= duration:
            raise ParameterError(
                f"campaign {campaign.name}: 'settled_after' is {after:g} s, flight {number} ends "
                f"after {duration:g} s"
            )


def _stream(campaign: Campaign, draw: int, key: str) -> np.random.Generator:
    return np.random.default_rng([campaign.seed, draw, zlib.crc32(key.encode())])


def _group_of(campaign: Campaign, draw: int) -> tuple[Group, int]:
    """Group of a draw, and its rank in it: groups follow one another."""
    begin, share = 0, 0.0
    for group in campaign.groups:
        share += group.share
        end = round(share * campaign.flights)
        if draw < end:
            return group, draw - begin
        begin = end
    return campaign.groups[-1], draw - begin


def _errors_of(campaign: Campaign, group: Group, rank: int) -> list[str]:
    names = list(campaign.errors)
    if group.errors == ONE:
        return [names[rank % len(names)]]
    return names if group.errors == ALL else []
