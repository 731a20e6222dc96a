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

"""Whether a link keeps what :class:`VehicleLink` asks for."""

from __future__ import annotations

import math

import numpy as np

from uav_tracking_mpc.links import LinkError, VehicleLink
from uav_tracking_mpc.parameters.conformance import ConformanceError, require, require_name
from uav_tracking_mpc.simulation.plants.conformance import check_measurement

STATES = 40  # that are looked at
WAIT = 2.0  # s for each
LEVEL = np.zeros((4, 3))  # rad/s, rad/s, m/s^2: a plan of straight and level flight


def check_link(link: type[VehicleLink], address: str = "") -> None:
    """Connect to an aircraft, listen to it, command straight and level flight, let go of it.

    Args:
        link: Class of the link.
        address: Where its aircraft is: a simulated one, for it is flown.

    Raises:
        ConformanceError: A state cannot be one, stamps do not follow each other or are not of the
            link's clock, a plan that is empty or not finite is accepted, one that can be flown is
            not, or there are states after it is closed.
        LinkError: There is no aircraft.
    """
    name = require_name(link)
    silent = getattr(link, "when_silent", "")
    require(silent, f"{name}: `when_silent` must say what the aircraft does without commands")
    with link(address) as connected:
        before = -math.inf
        for _ in range(STATES):
            state = connected.measured(WAIT)
            if state is None:
                raise ConformanceError(f"{name}: no state within {WAIT:g} s")
            stamp, now = state.stamp, connected.now()
            check_measurement(state, f"{name}: state of {stamp:g} s")
            require(before < stamp, f"{name}: stamp {stamp} s follows {before} s")
            require(
                abs(now - stamp) <= WAIT,
                f"{name}: a state of {stamp} s is new at {now} s: stamps must be of now()'s clock",
            )
            before, refusal = stamp, connected.command(now, LEVEL, 0.5)
            require(refusal == "", f"{name}: straight and level flight is refused: {refusal}")
        for kind, bad in {"not finite": LEVEL * math.nan, "empty": LEVEL[:0]}.items():
            words = f"{name}: a plan that is {kind} must be refused in words, it"
            try:
                require(connected.command(connected.now(), bad, 0.5), f"{words} is accepted")
            except (IndexError, TypeError, ValueError, ArithmeticError) as error:
                raise ConformanceError(f"{words} raises {error!r}") from error
    words = f"{name}: after close() measured() must raise LinkError, it"
    try:
        state = connected.measured(0.0)
    except LinkError:
        return
    except (AttributeError, TypeError, ValueError) as error:
        raise ConformanceError(f"{words} raises {error!r}") from error
    raise ConformanceError(f"{words} gives {state!r}")
