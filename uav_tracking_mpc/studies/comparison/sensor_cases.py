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

"""What is asked of the controller where a sensor fails in flight.

Range and airspeed are judged from a while after the sensor has begun to fail on, the airspeed also
by the aircraft's own limits in the whole flight; the sensor's health by what the controller has
said of it and when.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from uav_tracking_mpc.estimation.sensor_health import USED
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.flight_log import SensorNews
from uav_tracking_mpc.studies.comparison.asked import (
    ASKED,
    ASKED_ON_JSBSIM,
    CONFIGURATION,
    TARGETS,
    Asked,
    Flights,
    Target,
)
from uav_tracking_mpc.studies.comparison.sensor_faults import BEGIN, END, HEIGHT_STEP, JUMP

NEVER_BELOW, NEVER_ABOVE = 14.0, 32.0  # m/s, of small_uav
RECOVERED = 20.0  # s, after which a sensor that is right again is used again


@dataclass(frozen=True)
class AskedOfSensors(Asked):
    """What is asked where a sensor fails, besides range and bank rate.

    Attributes:
        worst: Of the range error at most in [m].
        airspeed: Of the airspeed's error at most in [m/s].
        overshoot: Of the altitude at most in [m], where the measured height steps up and down.
        slowest: Least airspeed of the whole flight in [m/s].
        named: The sensor that is to be named; empty if none.
        within: Time in [s] from the begin in which it is to be named.
        departed: Likewise from when the true airspeed is 1.5 m/s off, if ever.
        recovers: Whether it is to be used again once it is right.
        quiet: Whether no sensor may be named.
        begin: When it begins to fail in [s].
    """

    range_rms: float = math.inf
    bank_rate_rms: float = math.inf
    worst: float = math.inf
    airspeed: float = math.inf
    overshoot: float = math.inf
    slowest: float = NEVER_BELOW
    named: str = ""
    within: float = math.inf
    departed: float = math.inf
    recovers: bool = False
    quiet: bool = False
    begin: float = BEGIN
    judged: tuple[str, ...] = ("bank",)  # the airspeed is judged by its own bounds

    def words(self, flights: Flights) -> str:
        """For instance ``worst 0.3 m, airspeed 1.5 m/s, airspeed named in 2 s``."""
        words = [words] if (words := super().words(flights)) else []
        if math.isfinite(self.worst):
            words.append(f"worst {self.worst:g} m")
        if math.isfinite(self.airspeed):
            words.append(f"airspeed {self.airspeed:g} m/s")
        if math.isfinite(self.overshoot):
            words.append(f"overshoot {self.overshoot:g} m")
        if self.named:
            limit = min(self.within, self.departed)
            words.append(f"{self.named} named" + f" in {limit:g} s" * math.isfinite(limit))
        return ", ".join(words)

    def as_json(self, flights: Flights) -> dict[str, Any]:
        """The figures as plain values, those that are not asked infinite or null."""
        return {
            **super().as_json(flights),
            "worst_m": self.worst,
            "airspeed_worst_mps": self.airspeed,
            "airspeed_min_mps": self.slowest,
            "airspeed_max_mps": NEVER_ABOVE,
            "named": self.named or None,
            "named_within_s": self.within,
        }

    def missed(self, configuration: Configuration, flights: Flights) -> list[str]:
        """What the predictive controller missed, in words; empty if it reached everything.

        Args:
            configuration: Not looked at.
            flights: Without one of the predictive controller nothing is judged.
        """
        words = super().missed(configuration, flights)
        if PREDICTIVE not in flights:
            return words
        own = flights[PREDICTIVE]
        if not own.worst_m <= self.worst:
            words.append(f"range error up to {own.worst_m:.3g} m, at most {self.worst:g} m")
        overshoot = max(own.altitude_max_m, -own.altitude_min_m - HEIGHT_STEP)
        if not overshoot <= self.overshoot:
            words.append(f"altitude overshoots by {overshoot:.2f} m, at most {self.overshoot:g} m")
        if not own.airspeed_worst_mps <= self.airspeed:
            words.append(
                f"airspeed up to {own.airspeed_worst_mps:.2f} m/s off, at most {self.airspeed:g}"
            )
        if own.airspeed_min_mps < self.slowest or own.airspeed_max_mps > NEVER_ABOVE:
            words.append(
                f"airspeed from {own.airspeed_min_mps:.1f} to {own.airspeed_max_mps:.1f} m/s, "
                f"must be from {self.slowest:g} to {NEVER_ABOVE:g}"
            )
        for flight, departed in zip(own.sensors, own.airspeed_departed_s, strict=True):
            words += self._unnamed(flight, departed)
        return words

    def _unnamed(self, told: tuple[SensorNews, ...], departed: float | None) -> Iterator[str]:
        """What was not told in time in one flight."""
        news = [(time, sensor, state) for time, sensor, state in told if state != USED]
        if self.quiet and news:
            time, sensor, state = news[0]
            yield f"the {sensor} was said to be {state} after {time:.1f} s"
        if not self.named:
            return
        when = next((t for t, sensor, _ in news if sensor == self.named and t >= self.begin), None)
        latest = self.begin + self.within
        if math.isfinite(self.departed):
            latest = math.inf if departed is None else departed + self.departed
        if when is None and (math.isfinite(latest) or not math.isfinite(self.departed)):
            yield f"the {self.named} was never named"
        elif when is not None and when > latest:
            yield f"the {self.named} was named after {when:.1f} s, must be after {latest:.1f} s"
        if self.recovers and when is not None:
            again = [t for t, sensor, state in told if sensor == self.named and state == USED]
            if not again or not END <= again[-1] <= END + RECOVERED:
                yield f"the {self.named} was not used again by {END + RECOVERED:g} s"


ASKED_OF_SENSORS = {
    "airspeed_plus_3": AskedOfSensors(worst=0.3, airspeed=1.5, named="airspeed", departed=5.0),
    "airspeed_at_26": AskedOfSensors(
        worst=0.3, airspeed=1.5, named="airspeed", departed=5.0, begin=0.0
    ),
    "airspeed_stuck_gusts": AskedOfSensors(limits=False, slowest=16.0, named="airspeed"),
    "airspeed_drift": AskedOfSensors(
        worst=0.3, airspeed=2.5, named="airspeed", within=25.0, recovers=True
    ),
    "airspeed_zero": AskedOfSensors(worst=0.3, named="airspeed", within=2.0, recovers=True),
    "airspeed_blocked": AskedOfSensors(worst=0.3, named="airspeed", within=10.0, recovers=True),
    "airspeed_none": AskedOfSensors(worst=0.3, slowest=16.0, begin=0.0),
    "airspeed_lost": AskedOfSensors(worst=0.3, slowest=16.0, named="airspeed"),
    "position_spikes": AskedOfSensors(worst=0.3, airspeed=0.5),
    # NPFG, given these positions as they are, is off by 5.6 m in the worst seed: 0.7 of that.
    "position_jumps": AskedOfSensors(3.9, 5.0, airspeed=0.5),
    "position_offset": AskedOfSensors(worst=JUMP, airspeed=0.5),
    "height_steps": AskedOfSensors(overshoot=1.0, airspeed=0.5),
    "position_frozen": AskedOfSensors(worst=1.0, named="position", within=5.0),
    "position_silent": AskedOfSensors(worst=1.0, named="position", within=5.0),
    "heading_30": AskedOfSensors(worst=0.3, named="heading"),
    "velocity_flip": AskedOfSensors(worst=0.3, airspeed=0.5),
    "wind_turns": AskedOfSensors(worst=0.06, airspeed=0.5, quiet=True),
    # Range RMS of NPFG about the target as it truly is, in the same flight.
    "figure8_noise": AskedOfSensors(3.84, 12.0),
    "stop_and_go_8": AskedOfSensors(3.84, 15.0),
    "zigzag_10": AskedOfSensors(3.26, 18.0),
    "dropout_straight": AskedOfSensors(worst=1.0),
    "dropout_circling": AskedOfSensors(worst=15.0),
}


def asked_of(configuration: Configuration, name: str) -> Target | Asked | None:
    """What is asked in a scenario or under a mismatch, by its name; None where nothing is."""
    if configuration.name != CONFIGURATION:
        return None
    if configuration.simulator.plant == "jsbsim":  # what flies, whatever the mission says
        return ASKED_ON_JSBSIM.get(name) or ASKED_OF_SENSORS.get(name)
    return TARGETS.get(name) or ASKED.get(name) or ASKED_OF_SENSORS.get(name)
