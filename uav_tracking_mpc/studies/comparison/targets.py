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

"""What the predictive controller is to reach with ``small_uav``, and whether it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.comparison.measures import Measures

CONFIGURATION = "small_uav"
AIRSPEED_RMS = 0.3  # m/s, where the air has no gusts
BANK_RATE_RMS = 5.0  # deg/s, where the target's position is noisy
WORSE_BY = 0.05  # m of range RMS, over the better classical law
LATER_BY = 3.0  # s of settling, after the better classical law, where the air has no gusts


@dataclass(frozen=True)
class Target:
    """Of one scenario.

    Attributes:
        range_rms: In [m].
        settling: In [s].
    """

    range_rms: float
    settling: float


TARGETS = {
    "still": Target(0.03, 20.0),
    "wind": Target(0.03, 20.0),
    "crosswind": Target(0.03, 25.0),
    "headwind": Target(0.03, 35.0),
    "tight_headwind": Target(0.1, 45.0),
    "circling_target": Target(0.5, 30.0),
    "gusts": Target(0.4, 20.0),
    "noisy_target": Target(1.0, 30.0),
}


def target_of(configuration: Configuration, scenario: str) -> Target | None:
    """Target of a scenario; None where none is set.

    Args:
        configuration: What was flown.
        scenario: Name of the scenario.
    """
    return TARGETS.get(scenario) if configuration.name == CONFIGURATION else None


def missed(
    target: Target, configuration: Configuration, flights: Mapping[str, Measures]
) -> list[str]:
    """What the predictive controller missed, in words; empty if it reached everything.

    Args:
        target: Of the scenario.
        configuration: Of the scenario.
        flights: Each law's flight through it; without one of the predictive controller nothing
            is judged, without classical laws nothing is compared.
    """
    if PREDICTIVE not in flights:
        return []
    own = flights[PREDICTIVE]
    words = []
    if not own.range_rms_m <= target.range_rms:
        words.append(f"range RMS {own.range_rms_m:.3f} m, at most {target.range_rms:g} m")
    if own.settling_s is None or own.settling_s > target.settling:
        when = "never" if own.settling_s is None else f"after {own.settling_s:.1f} s"
        words.append(f"within 10 m {when}, at most {target.settling:g} s")
    if own.envelope_violations:
        limits = ", ".join(f"{name} {count}" for name, count in own.violations.items())
        words.append(f"{own.envelope_violations} samples outside the envelope ({limits})")
    gusty = configuration.simulator.gust_intensity > 0.0
    if not gusty and not own.airspeed_rms_mps <= AIRSPEED_RMS:
        words.append(f"airspeed RMS {own.airspeed_rms_mps:.2f} m/s, at most {AIRSPEED_RMS:g} m/s")
    if configuration.target.noise > 0.0 and not own.bank_rate_rms_dps <= BANK_RATE_RMS:
        words.append(
            f"bank rate RMS {own.bank_rate_rms_dps:.2f} deg/s, at most {BANK_RATE_RMS:g} deg/s"
        )
    others = [flight for law, flight in flights.items() if law != PREDICTIVE]
    if others:
        best = min(others, key=lambda flight: flight.range_rms_m)
        words += _compared(own.range_rms_m, best.range_rms_m, _disturbed(configuration))
        if not gusty:
            words += _settled_later(own.settling_s, best.settling_s)
    return words


def _disturbed(configuration: Configuration) -> bool:
    """Whether target or air moves."""
    simulator, target = configuration.simulator, configuration.target
    moves = any(motion_of(target).velocity(0.0))
    return moves or any(simulator.wind) or simulator.gust_intensity > 0.0


def _settled_later(own: float | None, best: float | None) -> list[str]:
    if own is None or best is None or own <= best + LATER_BY:
        return []  # that it never settled has been said
    return [f"within 10 m after {own:.1f} s, {best:.1f} s by the better classical law"]


def _compared(own: float, best: float, disturbed: bool) -> list[str]:
    if disturbed and not own < best:
        return [f"range RMS {own:.3f} m, must be below {best:.3f} m of the better classical law"]
    if not own <= best + WORSE_BY:
        return [f"range RMS {own:.3f} m, {best:.3f} m by the better classical law"]
    return []
