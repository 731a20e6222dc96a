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

r"""What counts of a flight, and what the predictive controller is to reach of it.

Measures are from the true trajectory and the configuration's limits alone: nothing here asks the
controller. What depends on rates is that of the interval between two samples of the state, with the
mean of position, path angle and airspeed over it; the bank, for instance:

.. math:: \tan\phi = \frac{\bar v}{g} \frac{\Delta\psi}{\Delta t}

A plant that tells its roll angle is judged by that: its air velocity turns in every gust, its wings
do not.

What is asked is for ``small_uav``. In a scenario the figures are absolute, and it is compared with
the better classical law: the one with the least range RMS in the same flight. Under a mismatch they
are absolute or shares of those of that law.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, wrap_angle
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE
from uav_tracking_mpc.limits import TOLERANCE, Motion
from uav_tracking_mpc.limits.turn import Bank
from uav_tracking_mpc.report.metrics import flown_bank, settling_time
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.motions import motion_of

# Tolerances where gusts shake the aircraft.
SHAKEN, SHAKEN_BANK = 0.03, math.radians(2.0)  # -, rad: share of a bound, and bank
SETTLED = 10.0  # m of range error: coarser than in a report, for what every law reaches


@dataclass(frozen=True)
class Measures:
    """A flight in numbers; unless said otherwise those of its last third.

    Attributes:
        range_rms_m: Of r - r_d in [m].
        range_mean_m: Of r - r_d in [m].
        worst_m: Greatest abs(r - r_d) in [m].
        settling_s: Of the whole flight: first time from which on abs(r - r_d) < 10 m in [s]; None
            if never.
        altitude_rms_m: Of z - z_d in [m].
        airspeed_rms_mps: Of v - v_d in [m/s].
        bank_rate_rms_dps: Of the rate of the bank that was flown in [deg/s].
        swing_deg: Greatest difference between the bank that was flown and that of the orbit at the
            same azimuth, in the air and about the target as they are, in [deg].
        softened: Of the whole flight: greatest factor by which a limit cycle made changes of an
            input weigh more [-]; 1 where there was none.
        envelope_violations: Of the whole flight: samples at which some limit was passed by more
            than 1 %; where gusts shake an aircraft whose response is told wrong, by more than 3 %,
            and of the bank by more than 2 deg.
        violations: How many of them for each limit that was passed.
        off_plan: Commands that were neither an optimal plan nor the answer of the law that flew;
            None where that was not recorded.
    """

    range_rms_m: float
    range_mean_m: float
    worst_m: float
    settling_s: float | None
    altitude_rms_m: float
    airspeed_rms_mps: float
    bank_rate_rms_dps: float
    swing_deg: float
    softened: float
    envelope_violations: int
    violations: dict[str, int]
    off_plan: int | None


def measures(
    log: FlightLog,
    parameters: TrackingParameters,
    settled_after: float | None = None,
    shaken: bool = False,
) -> Measures:
    """Measure a flight.

    Args:
        log: Record of the flight, at least four samples.
        parameters: The limits.
        settled_after: Time in [s] from which on the flight counts; its last third by default.
        shaken: Whether limits are judged as where gusts shake the aircraft.
    """
    range_error, _, altitude_error, _, airspeed_error = log.error.T
    if settled_after is None:
        settled_after = 2.0 / 3.0 * (log.time[-1] - log.time[0])
    late = log.time >= log.time[0] + settled_after
    bank = flown_bank(log)
    bank_rate = np.diff(bank) / np.diff(log.time)[1:]  # at the samples but two
    swing = bank - _middle(_orbit_bank(log))
    tolerance = (SHAKEN, SHAKEN_BANK) if shaken else (TOLERANCE, 0.0)
    beyond = violations(log, parameters, *tolerance)
    off_plan = None
    if log.nominal is not None:
        counted = log.command_time >= log.time[0] + settled_after
        off_plan = int(np.count_nonzero(counted & ~log.nominal))
    return Measures(
        range_rms_m=_rms(range_error[late]),
        range_mean_m=float(np.mean(range_error[late])),
        worst_m=float(np.max(np.abs(range_error[late]))),
        settling_s=settling_time(log.time, range_error, SETTLED),
        altitude_rms_m=_rms(altitude_error[late]),
        airspeed_rms_mps=_rms(airspeed_error[late]),
        bank_rate_rms_dps=float(np.degrees(_rms(bank_rate[late[1:-1]]))),
        swing_deg=float(np.degrees(np.max(np.abs(swing[late[:-1]])))),
        softened=log.softened,
        envelope_violations=int(np.any(list(beyond.values()), axis=0).sum()),
        violations={name: int(found.sum()) for name, found in beyond.items() if found.any()},
        off_plan=off_plan,
    )


def worst(flights: Sequence[Measures]) -> Measures:
    """Each figure of the flight in which it is worst.

    Args:
        flights: At least one.
    """
    if len(flights) == 1:
        return flights[0]
    figures: dict[str, Any] = {}
    for field in dataclasses.fields(Measures):
        values = [getattr(flight, field.name) for flight in flights]
        if field.name == "violations":
            names = dict.fromkeys(name for value in values for name in value)
            figures["violations"] = {n: max(v.get(n, 0) for v in values) for n in names}
        elif None in values:  # never settled, or not recorded
            figures[field.name] = None
        else:
            figures[field.name] = max(values, key=abs)
    return Measures(**figures)


def violations(
    log: FlightLog,
    parameters: TrackingParameters,
    tolerance: float = TOLERANCE,
    bank_tolerance: float = 0.0,
) -> dict[str, NDArray[np.bool_]]:
    """At which samples which limit is passed by more than a tolerance, each of shape (n,).

    Bank and force are those of the interval after a sample.

    Args:
        log: Record of the flight.
        parameters: The limits.
        tolerance: As a share of the bound [-].
        bank_tolerance: Of the bank in [rad], where that is more; of a measured bank it is at least
            :data:`SHAKEN_BANK`.

    Returns:
        By the label of the limit.
    """
    at_samples, between = _at_samples(log), _between_samples(log)
    if log.measured_bank is not None:
        bank_tolerance = max(bank_tolerance, SHAKEN_BANK)
    passed = {}
    for limit in parameters.envelope.limits:
        motion, targets = at_samples, log.target
        if limit.of_rates:
            motion, targets = between, log.target[:-1]
        bound = limit.flown(motion, limit.numbers(targets).T)
        if bound is not None:
            allowed = tolerance
            if isinstance(limit, Bank):
                allowed = max(tolerance, bank_tolerance / limit.bank_max)
            # The last sample begins no interval.
            passed[limit.label] = np.append(bound.passed(allowed), False)[: len(log.time)]
    return passed


def _at_samples(log: FlightLog) -> Motion:
    x, y, z, _, path_angle, airspeed = log.vehicle.T
    x_target, y_target, z_target = log.target.T
    return Motion(x - x_target, y - y_target, z - z_target, path_angle, airspeed)


def _between_samples(log: FlightLog) -> Motion:
    samples, step = _at_samples(log), np.diff(log.time)
    _, _, _, heading, _, _ = log.vehicle.T
    turn_rate = np.asarray(wrap_angle(np.diff(heading))) / step
    if log.measured_bank is not None:
        turn_rate = -GRAVITY * np.tan(flown_bank(log)) / _middle(samples.airspeed)
    return Motion(
        x=_middle(samples.x),
        y=_middle(samples.y),
        z=_middle(samples.z),
        path_angle=_middle(samples.path_angle),
        airspeed=_middle(samples.airspeed),
        turn_rate=turn_rate,
        acceleration=np.diff(samples.airspeed) / step,
    )


def _orbit_bank(log: FlightLog) -> NDArray[np.float64]:
    """Bank of steady flight on the orbit at the azimuths of the samples, shape (n,), in [rad].

    psi' = sigma s^2 / (d q), as of :func:`~uav_tracking_mpc.dynamics.orbit.orbit_motion`.
    """
    x, y = (log.vehicle[:, :2] - log.target[:, :2]).T
    sense = 1.0 if log.orbit.direction == COUNTER_CLOCKWISE else -1.0
    distance, airspeed = np.hypot(x, y), log.vehicle[:, 5]
    t_x, t_y = -sense * y / distance, sense * x / distance
    c_x, c_y, _ = log.drift.T
    q = np.sqrt(np.maximum(airspeed**2 - (c_y * t_x - c_x * t_y) ** 2, 1e-3 * airspeed**2))
    s = c_x * t_x + c_y * t_y + q
    return np.asarray(bank_from_turn_rate(sense * s**2 / (log.radius * q), airspeed))


def _middle(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


CONFIGURATION = "small_uav"
AIRSPEED_RMS = 0.3  # m/s, where the air has no gusts
BANK_RATE_RMS, GUSTY_BANK_RATE_RMS = 5.0, 16.0  # deg/s, where the target is noisy, and in gusts
WORSE_BY = 0.05  # m of range RMS, over the better classical law
LATER_BY = 3.0  # s of settling, after the better classical law, where the air has no gusts
# Limits that a flight under a mismatch is not to pass; the force of the first climb is known only
# once the aircraft has answered.
JUDGED = ("bank", "airspeed", "path angle")

Flights = Mapping[str, Measures]  # of one scenario, by the law


@dataclass(frozen=True)
class Target:
    """What is asked in a scenario.

    Attributes:
        range_rms: In [m].
        settling: In [s].
    """

    range_rms: float
    settling: float

    def words(self, flights: Flights) -> str:
        """For instance ``0.4 m, 20 s``."""
        return f"{self.range_rms:g} m, {self.settling:g} s"

    def as_json(self, flights: Flights) -> dict[str, Any]:
        """The figures as plain values."""
        return {"range_rms_m": self.range_rms, "settling_s": self.settling}

    def missed(self, configuration: Configuration, flights: Flights) -> list[str]:
        """What the predictive controller missed, in words; empty if it reached everything.

        Args:
            configuration: What was flown.
            flights: Without one of the predictive controller nothing is judged, without classical
                laws nothing is compared.
        """
        if PREDICTIVE not in flights:
            return []
        own, words = flights[PREDICTIVE], []
        if not own.range_rms_m <= self.range_rms:
            words.append(f"range RMS {own.range_rms_m:.3f} m, at most {self.range_rms:g} m")
        if own.settling_s is None or own.settling_s > self.settling:
            when = "never" if own.settling_s is None else f"after {own.settling_s:.1f} s"
            words.append(f"within 10 m {when}, at most {self.settling:g} s")
        if own.envelope_violations:
            limits = ", ".join(f"{name} {count}" for name, count in own.violations.items())
            words.append(f"{own.envelope_violations} samples outside the envelope ({limits})")
        simulator, target = configuration.simulator, configuration.target
        gusty = simulator.gust_intensity > 0.0
        for name, value, bound, unit, asked in (
            ("airspeed", own.airspeed_rms_mps, AIRSPEED_RMS, "m/s", not gusty),
            ("bank rate", own.bank_rate_rms_dps, BANK_RATE_RMS, "deg/s", target.noise > 0.0),
            ("bank rate", own.bank_rate_rms_dps, GUSTY_BANK_RATE_RMS, "deg/s", gusty),
        ):
            if asked and not value <= bound:
                words.append(f"{name} RMS {value:.2f} {unit}, at most {bound:g} {unit}")
        best = _better(flights)
        if best is None:
            return words
        others = flights[best]
        figures = f"range RMS {own.range_rms_m:.3f} m, {{}}{others.range_rms_m:.3f} m {{}} law"
        disturbed = gusty or any(simulator.wind) or any(motion_of(target).velocity(0.0))
        if disturbed and not own.range_rms_m < others.range_rms_m:
            words.append(figures.format("must be below ", "of the better classical"))
        elif not own.range_rms_m <= others.range_rms_m + WORSE_BY:
            words.append(figures.format("", "by the better classical"))
        first, second = own.settling_s, others.settling_s
        if not (gusty or first is None or second is None or first <= second + LATER_BY):
            words.append(
                f"within 10 m after {first:.1f} s, {second:.1f} s by the better classical law"
            )
        return words


def _better(flights: Flights) -> str | None:
    """The classical law with the least range RMS; None where none has flown."""
    others = [law for law in flights if law != PREDICTIVE and law not in ASKED]
    return min(others, key=lambda law: flights[law].range_rms_m) if others else None


BETTER = "the better law"


@dataclass(frozen=True)
class Asked:
    """What is asked under a mismatch; what is infinite is not asked.

    Attributes:
        range_rms: At most, in [m].
        bank_rate_rms: At most, in [deg/s].
        range_mean: Magnitude at most, in [m].
        relative: Whose range and bank rate RMS they are shares of [-]: :data:`BETTER`, the better
            classical law's, or those of a law, or of the controller under another mismatch; empty
            where they are absolute.
        law: Whose they were; empty where they are absolute.
        limits: Whether no limit may be passed.
        optimal: Whether every command that counts is to be an optimal plan.
        swing: Of the bank about that of the orbit, at most, in [deg].
        after: Time in [s] from which on the flight counts; None for the usual one.
        shaken: Whether limits are judged as where gusts shake the aircraft.
        unswung: Whether no limit cycle may be told, and the loop not be softened.
    """

    range_rms: float
    bank_rate_rms: float
    range_mean: float = math.inf
    relative: str = ""
    law: str = ""
    limits: bool = True
    optimal: bool = False
    swing: float = math.inf
    after: float | None = None
    shaken: bool = False
    unswung: bool = False

    def resolved(self, flights: Flights) -> Asked:
        """The figures as absolute ones; without classical laws what is relative is not asked."""
        if not self.relative:
            return self
        law = _better(flights) if self.relative == BETTER else self.relative
        range_rms = bank_rate = math.inf
        if law is not None and law in flights:
            range_rms = self.range_rms * flights[law].range_rms_m
            bank_rate = self.bank_rate_rms * flights[law].bank_rate_rms_dps
        else:
            law = ""
        return dataclasses.replace(
            self, relative="", law=law, range_rms=range_rms, bank_rate_rms=bank_rate
        )

    def words(self, flights: Flights) -> str:
        """For instance ``0.5 m, 3 deg/s``."""
        bounds = self.resolved(flights)
        shares = f"({self.range_rms:g}, {self.bank_rate_rms:g} x {bounds.law or self.relative})"
        if self.relative and not bounds.law:
            return shares
        asked = {
            "{:.3g} m": bounds.range_rms,
            "{:.3g} deg/s": bounds.bank_rate_rms,
            "mean {:g} m": self.range_mean,
            "swing {:g} deg": self.swing,
        }
        words = [form.format(value) for form, value in asked.items() if math.isfinite(value)]
        if self.unswung:
            words.append("no limit cycle")
        return ", ".join(words) + (f" {shares}" if self.relative else "")

    def as_json(self, flights: Flights) -> dict[str, Any]:
        """The figures as plain values, those that are not asked infinite or null."""
        bounds = self.resolved(flights)
        return {
            "range_rms_m": bounds.range_rms,
            "range_mean_m": bounds.range_mean,
            "bank_rate_rms_dps": bounds.bank_rate_rms,
            "swing_deg": self.swing,
            "softened": 1.0 if self.unswung else None,
            "envelope_violations": 0 if self.limits else None,
            "off_plan": 0 if self.optimal else None,
            "of_law": bounds.law or None,
            "range_rms_share": self.range_rms if self.relative else None,
            "bank_rate_rms_share": self.bank_rate_rms if self.relative else None,
        }

    def missed(self, configuration: Configuration, flights: Flights) -> list[str]:
        """What the predictive controller missed, in words; empty if it reached everything.

        Args:
            configuration: Not looked at.
            flights: Without one of the predictive controller nothing is judged.
        """
        if PREDICTIVE not in flights:
            return []
        own, bounds, words = flights[PREDICTIVE], self.resolved(flights), []
        for name, value, bound, unit, share in (
            ("range RMS", own.range_rms_m, bounds.range_rms, "m", self.range_rms),
            ("mean of the range error", abs(own.range_mean_m), bounds.range_mean, "m", None),
            (
                "bank rate RMS", own.bank_rate_rms_dps, bounds.bank_rate_rms, "deg/s",
                self.bank_rate_rms,
            ),
            ("swing of the bank", own.swing_deg, self.swing, "deg", None),
        ):  # fmt: skip
            if not value <= bound:
                compared = bounds.law and share is not None
                of_law = f", {share:g} times that of {bounds.law}" if compared else ""
                words.append(f"{name} {value:.3g} {unit}, at most {bound:.3g} {unit}{of_law}")
        beyond = [f"{name} {own.violations[name]}" for name in JUDGED if name in own.violations]
        if self.limits and beyond:
            words.append(f"samples outside the envelope: {', '.join(beyond)}")
        if self.unswung and own.softened > 1.0:
            words.append(f"the loop was softened {own.softened:.0f} times")
        if self.optimal and own.off_plan:
            words.append(f"{own.off_plan} commands off the optimal plan")
        return words


TARGETS = {
    "still": Target(0.03, 20.0),
    "wind": Target(0.03, 20.0),
    "crosswind": Target(0.03, 25.0),
    "headwind": Target(0.03, 35.0),
    "tight_headwind": Target(0.1, 45.0),
    "circling_target": Target(0.5, 30.0),
    "gusts": Target(0.65, 20.0),
    "noisy_target": Target(1.0, 30.0),
}
_WRONG_LAG, _NEARLY_RIGHT = Asked(0.5, 3.0), Asked(0.05, 1.0)
_BIASED = Asked(0.3, 2.0, range_mean=0.1)
_GUSTY = Asked(0.7, 1.25, relative="l1", limits=False)
_GUSTY_LAG = Asked(1.3, 1.3, relative="gust_moderate", shaken=True)
_LATER = Asked(0.5, math.inf, swing=3.0, after=130.0)
ASKED = {
    "lag_0": _WRONG_LAG,
    "lag_0.25": _WRONG_LAG,
    "lag_0.5": _WRONG_LAG,
    "lag_0.75": _NEARLY_RIGHT,
    "lag_1.5": _NEARLY_RIGHT,
    "lag_2": _WRONG_LAG,
    "lag_3": _WRONG_LAG,
    # About a target of 5 m/s a state that is late without saying so costs 0.33 and 0.98 m.
    "late_0.1": Asked(0.45, 3.0),
    "late_0.3": Asked(1.1, 3.0),
    "stamped_0.3": _NEARLY_RIGHT,
    "noise_0.5": Asked(0.35, 5.0, optimal=True),
    "noise_2": Asked(0.6, 5.0, optimal=True),
    "noise_5": Asked(1.2, 5.0, optimal=True),
    "wind_bias_2": _BIASED,
    "heading_bias_5": _BIASED,
    "airspeed_bias_2": _BIASED,
    "turn_rate_bias_2": _BIASED,
    "gust_light": _GUSTY,
    "gust_moderate": _GUSTY,
    "gust_severe": _GUSTY,
    **{f"gust_lag_{share}": _GUSTY_LAG for share in ("0", "0.25", "0.5", "2", "3")},
    "delay_100": _LATER,
    "delay_200": _LATER,
    "delay_400": dataclasses.replace(_LATER, after=140.0),
    "second_order_roll": Asked(0.5, math.inf, swing=3.0, shaken=True),
    "weaving_target": Asked(math.inf, math.inf, limits=False, unswung=True),
    "tight_gale": Asked(1.5, 1.5, relative=BETTER),
    "zigzag": Asked(0.8, 1.5, relative=BETTER),
    "sensor_noise": Asked(0.1, 2.0, limits=False),
}
ASKED_ON_JSBSIM = {
    **{name: Asked(0.1, 1.0, limits=False) for name in ASKED if name.startswith("lag_")},
    "gust_light": Asked(0.2, 5.0, limits=False),
    "gust_moderate": Asked(0.4, 9.0, limits=False),
}


def asked_of(configuration: Configuration, name: str) -> Target | Asked | None:
    """What is asked in a scenario or under a mismatch, by its name; None where nothing is."""
    if configuration.name != CONFIGURATION:
        return None
    if configuration.simulator.plant == "jsbsim":  # what flies, whatever the mission says
        return ASKED_ON_JSBSIM.get(name)
    return TARGETS.get(name) or ASKED.get(name)
