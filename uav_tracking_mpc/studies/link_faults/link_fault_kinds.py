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

"""What strikes a flight over a link: the wire's faults, and what pilots and companions do."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.autopilot.wire_faults import WIRE_FAULTS
from uav_tracking_mpc.studies.link_faults.link_flight import LinkFlight

HAND_FLOWN = {"ardupilot": ("FBWA", "MANUAL", "RTL", "LOITER"), "px4": ("STABILIZED", "HOLD")}
DEAD_TIME = (10.0, 40.0)  # s without the companion
AFTERWARDS = 3.0  # s that a pilot is watched for

Strike = Callable[[LinkFlight, random.Random], float]


def wire(name: str) -> Strike:
    """A fault of the wire.

    Args:
        name: One of :data:`~uav_tracking_mpc.autopilot.wire_faults.WIRE_FAULTS`.
    """

    def strike(flight: LinkFlight, random_: random.Random) -> float:
        duration = random_.uniform(*WIRE_FAULTS[name].duration)
        fault = flight.autopilot.begin_fault(name, random_.randrange(2**31))
        end = flight.time + duration
        while flight.time < end:
            flight.step()
        flight.autopilot.end_fault(fault)
        return duration

    return strike


def take_over(flight: LinkFlight, random_: random.Random) -> float:
    """The pilot switches to another mode; nothing may be commanded after the message that says so.

    Args:
        flight: Under way.
        random_: Where all that is random comes from.

    Returns:
        How long it lasted in [s].
    """
    modes = [
        mode
        for modes in HAND_FLOWN.values()
        for mode in modes
        if mode in flight.autopilot.core.modes
    ]
    heard, told = flight.link.heard, list[int]()
    before = heard.on_message

    def listen(message: Any, arrival: float) -> None:
        before(message, arrival)
        tells = message.get_type() in ("HEARTBEAT", "CURRENT_MODE")
        if tells and not flight.link.takes_commands(message.custom_mode):
            told.append(flight.sent.set_points)

    heard.on_message = listen
    mode = random_.choice(modes)
    flight.autopilot.pilot_mode(mode)
    end = flight.time + AFTERWARDS
    while flight.time < end:
        flight.step()
    heard.on_message = before
    late = flight.sent.set_points - told[0] if told else flight.sent.set_points
    if late or flight.link.engaged:
        flight.sent.blame("take-over", f"{late} set-points after mode {mode} was told")
    return AFTERWARDS


def companion_dead(flight: LinkFlight, random_: random.Random) -> float:
    """The companion is dead for a while, then comes back as if nothing had been.

    Args:
        flight: Under way.
        random_: Where all that is random comes from.

    Returns:
        How long it lasted in [s].
    """
    duration = random_.uniform(*DEAD_TIME)
    flight.silent(duration)
    return duration


KINDS: dict[str, Strike] = {
    **{name: wire(name) for name in WIRE_FAULTS},
    "take_over": take_over,
    "companion_dead": companion_dead,
}
