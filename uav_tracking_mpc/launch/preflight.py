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

"""Before a flight with a real autopilot: what is found there, and the envelope that follows.

What is read of the vehicle takes the place of what the configuration says of it, but a limit only
where it is tighter: a vehicle never loosens what was asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.links import VEHICLE_LINK, Inspection, LinkRefusedError, VehicleLink
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import TrackingParameters

WIND_STATES, WIND_WAIT = 25, 2.0  # -, s: states that the wind is taken from, and the time for them
HELD = "hold_"  # begins the names of what the autopilot does itself, which is no limit of ours
SAME = 1e-9  # -, relative difference up to which two numbers are the same


@dataclass(frozen=True)
class Preflight:
    """What a link found, and what is flown with it.

    Attributes:
        inspection: What was found.
        configuration: With the vehicle's limits in it; that of before where they cannot be flown.
        changes: What the vehicle's limits changed, in words.
        wind: Velocity of the air in ``map``, shape (3,), in [m/s]; None where it is not known.
        refusals: Why it cannot be flown, in words; empty if it can.
    """

    inspection: Inspection
    configuration: Configuration
    changes: tuple[str, ...]
    wind: NDArray[np.float64] | None
    refusals: tuple[str, ...]


def preflight(configuration: Configuration, timeout: float) -> Preflight:
    """Connect, look, let go again; nothing is commanded.

    Args:
        configuration: To be flown, with the link in its section ``autopilot_link``.
        timeout: How long to try to connect in [s].

    Raises:
        ExtensionError: There is no such link.
        LinkError: There is no aircraft, or none that this link flies.
    """
    kind = VEHICLE_LINK.find(configuration.link.link)
    link: VehicleLink = kind.of(configuration.link)
    try:
        link.connect(timeout)
        inspection = link.inspect()
        wind = _wind(link)
    finally:
        link.close()
    envelope = (
        {"autopilot_holds": True, **inspection.envelope} if link.holds else inspection.envelope
    )
    refusals = list(inspection.refusals)
    try:
        fitted, changes = with_envelope(configuration, envelope)
        if wind is not None and (words := refusal(fitted.controller, wind)):
            refusals.append(words)
    except ParameterError as error:
        fitted, changes = configuration, ()
        refusals.append(str(error))
    return Preflight(inspection, fitted, changes, wind, tuple(refusals))


def refusal(parameters: TrackingParameters, wind: NDArray[np.float64]) -> str:
    """Why the orbit cannot be flown in a wind, in words; empty if it can.

    Args:
        parameters: With the vehicle's limits.
        wind: In ``map``, shape (3,), in [m/s]; its part up or down is a gust's, which passes.
    """
    east, north, _ = wind.tolist()
    words = parameters.envelope.refusal(parameters.orbit, np.array([east, north, 0.0]))
    return f"in the wind of {math.hypot(east, north):.1f} m/s there: {words}" if words else ""


def refuse(found: Preflight) -> None:
    """Make sure that it can be flown.

    Args:
        found: Before the flight.

    Raises:
        LinkRefusedError: It cannot.
    """
    if found.refusals:
        raise LinkRefusedError("; ".join(found.refusals))


def with_envelope(
    configuration: Configuration, envelope: Mapping[str, Any]
) -> tuple[Configuration, tuple[str, ...]]:
    """The configuration with a vehicle's limits, and what they changed in words.

    Args:
        configuration: As asked for.
        envelope: Parameters of the controller by name, in the units of
            :class:`TrackingParameters`.

    Raises:
        ParameterError: What is asked for cannot be flown by this vehicle.
    """
    present, values, changes = configuration.controller, dict[str, Any](), []
    limits = {**_fence(present, envelope), **_forces(present, envelope)}
    for name, value in {**envelope, **limits}.items():
        before = getattr(present, name, None)
        if isinstance(before, float):
            value = _tighter(name, before, value)
        if before is None or not _same(before, value):
            values[name] = list(value) if isinstance(value, tuple) else value
            if before is not None and _words(before) != _words(value):
                changes.append(f"{name} is {_words(value)} by the vehicle, not {_words(before)}")
    return configuration.changed("nmpc_controller", values), tuple(changes)


def _fence(present: TrackingParameters, envelope: Mapping[str, Any]) -> dict[str, Any]:
    """The fence that lies inside the other; the vehicle's where neither does."""
    radius = envelope.get("fence_radius")
    if radius is None or not present.fence_radius:
        return {}
    apart = math.dist(envelope.get("fence_centre", (0.0, 0.0)), present.fence_centre)
    if apart + present.fence_radius > radius:
        return {}
    return {"fence_radius": present.fence_radius, "fence_centre": present.fence_centre}


def _forces(present: TrackingParameters, envelope: Mapping[str, Any]) -> dict[str, Any]:
    """The tighter forces at the ends of the airspeeds that are left."""
    own = present.airspeed_min, present.airspeed_max
    vehicles = [envelope.get(f"airspeed_{end}", own[i]) for i, end in enumerate(("min", "max"))]
    ends = max(own[0], vehicles[0]), min(own[1], vehicles[1])
    return {
        name: tuple(
            choose(
                np.interp(ends, own, getattr(present, name)), np.interp(ends, vehicles, given)
            ).tolist()
        )
        for name, choose in {"force_min": np.maximum, "force_max": np.minimum}.items()
        if (given := envelope.get(name)) is not None
    }


def _tighter(name: str, before: float, value: float) -> float:
    """The tighter of two limits; the vehicle's number where it is none."""
    choose = {"_max": min, "_min": max}.get(name[-4:])
    return value if choose is None or name.startswith(HELD) else choose(before, value)


def _same(before: Any, value: Any) -> bool:
    if isinstance(before, (bool, str)) or isinstance(value, (bool, str)):
        return bool(before == value)
    return np.shape(before) == np.shape(value) and np.allclose(before, value, rtol=SAME, atol=SAME)


def _words(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(f'{number:.4g}' for number in value)}]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _wind(link: VehicleLink) -> NDArray[np.float64] | None:
    """Median of the wind triangles of some states; None without an airspeed."""
    winds: list[NDArray[np.float64]] = []
    end = link.now() + WIND_WAIT
    while len(winds) < WIND_STATES and link.now() < end:
        measurement = link.measured(0.1)
        if measurement is not None and measurement.airspeed is not None:
            through_air = velocity(measurement.state(measurement.airspeed))
            winds.append(measurement.ground_velocity - through_air)
    return np.asarray(np.median(winds, axis=0)) if winds else None
