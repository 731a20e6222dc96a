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

"""What is steered: orbit, target, wind, simulated time, engagement, faults, laws flown beside."""

from __future__ import annotations

import functools
import html
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from uav_tracking_mpc.settings.simulator import SimulatorParameters, TargetParameters
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.motions import TARGET_MOTION
from uav_tracking_mpc.simulation.plants import AIR, PLANT
from uav_tracking_mpc.view.panel._html import (
    CALM,
    badge,
    block,
    duration,
    faint,
    mode_badge,
    number,
    table,
)
from uav_tracking_mpc.view.panel._steering_part import ParameterPart, SteeringPart, set_slider
from uav_tracking_mpc.view.panel.readings import columns
from uav_tracking_mpc.view.watched_flight import (
    CONTROLLER,
    RATES,
    SIMULATOR,
    TARGET,
    FlightSource,
    Sight,
    WatchedFlight,
)

DEEP = -1e4  # m; a least height below that is none
FAST = 15.0  # m/s, of a car in town
STRONG, SEVERE = 15.0, 25.0  # m/s of wind, and of gusts (23.2 is severe)
STILL = 0.01  # m/s; slower wind comes from nowhere
STANDS = 1.0  # s of wall time without a new state after which time is said to stand


class Orbit(ParameterPart):
    """The orbit to fly, as parameters of the controller: three sliders and a list."""

    name = "orbit"
    title, node, section = "Orbit", CONTROLLER, TrackingParameters
    order = 20.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`: also unflyable values, for the controller to refuse."""
        range_, altitude, speed = (float(known[key]) for key in ("range", "altitude", "airspeed"))
        floor = float(known.get("height_min", DEEP))
        low = min(0.0 if floor <= DEEP else floor, altitude)
        slowest = float(known.get("airspeed_min", 0.5 * speed))
        fastest = min(float(known.get("airspeed_max", math.inf)), 3.0 * speed)
        self.add_slider("range", known, 0.1 * range_, 3.0 * range_)
        self.add_slider("altitude", known, low, max(2.0 * altitude, range_))
        self.add_slider("airspeed", known, slowest, fastest)
        self.add_choice("direction", known, self.described["direction"].choices)


class Target(ParameterPart):
    """How the target moves: a list of motions and a slider."""

    name = "target"
    title, node, section = "Target", TARGET, TargetParameters
    order = 25.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`."""
        hint = "A new motion begins where the target is. One that needs a speed needs it below."
        self.add_choice("motion", known, TARGET_MOTION.names, hint)
        self.add_slider("speed", known, 0.0, FAST)


class Wind(ParameterPart):
    """Wind and gusts of the simulator: how fast, from where, how gusty."""

    name = "wind"
    title, node, section = "Wind", SIMULATOR, SimulatorParameters
    order = 30.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`; not every plant has air that can be changed."""
        plant = known["plant"]
        if plant in PLANT.own_names and not set(AIR) <= set(PLANT.find(plant).changeable):
            self.folder.visible = False
            return
        speed, azimuth = from_where(known["wind"])
        self._speed = self.gui.add_slider(
            "wind [m/s]",
            0.0,
            max(STRONG, speed),
            0.5,
            speed,
            hint=self.described["wind"].description,
        )
        self._from: Any = self.gui.add_slider(
            "from [deg]",
            0.0,
            360.0,
            5.0,
            azimuth,
            marks=((0.0, "N"), (90.0, "E"), (180.0, "S"), (270.0, "W"), (360.0, "N")),
            hint="Where the wind comes from: 0 is north, 90 is east.",
        )
        self._up = float(known["wind"][2])
        self.steer(self._speed, self._follow, self._wind)
        self.steer(self._from, self._follow, self._wind)
        self.add_slider("gust_intensity", known, 0.0, SEVERE, "gusts")

    def _follow(self, known: Mapping[str, Any]) -> None:
        speed, azimuth = from_where(known["wind"])
        self._up = float(known["wind"][2])
        set_slider(self._speed, speed)
        if speed > STILL and azimuth != self._from.value % 360.0:  # north is at both ends
            self._from.value = azimuth

    def _wind(self) -> dict[str, Any]:
        azimuth = math.radians(self._from.value)
        east, north = (-self._speed.value * f(azimuth) for f in (math.sin, math.cos))
        return {"wind": (round(east, 6) + 0.0, round(north, 6) + 0.0, self._up)}


def from_where(wind: tuple[float, ...]) -> tuple[float, float]:
    """Speed of the wind in [m/s] and the azimuth that it comes from in [deg], from north over east.

    Still air comes from the north.

    Args:
        wind: Where it blows to in ``map``, east, north and up in [m/s].
    """
    east, north = float(wind[0]), float(wind[1])
    speed = math.hypot(east, north)
    azimuth = math.degrees(math.atan2(-east, -north)) if speed > STILL else 0.0
    return round(speed, 3), round(azimuth % 360.0, 1) % 360.0


class SimulatedTime(ParameterPart):
    """Simulated time: a row of buttons and a list of speeds."""

    name = "simulated_time"
    title, node, section = "Simulated time", SIMULATOR, SimulatorParameters
    order = 50.0

    _time, _since = math.nan, 0.0  # of the last new state: of the flight, and of the wall [s]

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`."""
        self.add_choice("speed", known, RATES, "Simulated over wall time.", "{:g} x")
        self.add_buttons(
            "time",
            {
                "Pause": lambda: self.steering.pause(True),
                "Go on": lambda: self.steering.pause(False),
                "Reset": self.steering.reset,
            },
            "Reset puts the aircraft back to where it started.",
        )

    def show(self, sight: Sight) -> None:
        """Say also whether time stands still.

        Args:
            sight: Of this aircraft.
        """
        super().show(sight)
        now = time.monotonic()
        if sight.time != self._time:
            self._time, self._since = sight.time, now
        stands = now - self._since > STANDS
        self.folder.label = f"{self.title}: stands still" if stands else self.title


class Engagement(SteeringPart):
    """Whether the controller commands the aircraft: a row of two buttons."""

    name = "engagement"
    title, node = "Controller", CONTROLLER
    order = 45.0

    def add(self) -> None:
        """Add the buttons."""
        super().add()
        with self.folder:
            self.add_buttons(
                "commands",
                {
                    "Engage": lambda: self.steering.engage(True),
                    "Disengage": lambda: self.steering.engage(False),
                },
                "Let the controller command, or keep it silent.",
            )


PATIENCE = 30.0  # s of the flight's clock in which a fault shows, or does not


class Faults(SteeringPart):
    """A row of buttons, and the story of the last one."""

    name = "faults"
    title = "Faults"
    order = 35.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether there are faults to inject.

        Args:
            flight: What is steered.
            source: Where it comes from.
        """
        return flight.steering is not None and bool(flight.steering.faults)

    def add(self) -> None:
        """Add the buttons."""
        super().add()
        self._fault = ""
        # Times of the flight: a fault was asked for, and begun; a fallback was flown last; now.
        self._asked = self._since = self._left = self._now = float("nan")
        self._story = ""  # how the last fault ended, as HTML; empty until it has
        self._offered: dict[str, Callable[[], str]] = {}
        hint = self._take_offers()
        with self.folder:
            self._told = self.gui.add_html("", order=0.0, visible=False)
            self._buttons = self.add_buttons("inject", self._offered, hint, self._begun)

    def _take_offers(self) -> str:
        """Take also what is offered only now, for nodes come one by one; says what each does."""
        faults = self.steering.faults
        for fault in faults:
            self._offered.setdefault(fault, functools.partial(self._inject, fault))
        return "; ".join(f"{fault}: {words}" for fault, words in faults.items())

    def _inject(self, fault: str) -> str:
        self._asked = self._now  # the fallback may be over when a late answer comes
        return self.steering.inject(fault)

    def _begun(self, fault: str) -> None:
        self._since, self._fault, self._story = self._asked, fault, ""

    def show(self, sight: Sight) -> None:
        """Tell what the last fault does to the flight.

        Args:
            sight: Of this aircraft.
        """
        if sight.time < self._now:  # put back to its start
            self._left, self._fault, self._told.visible = float("nan"), "", False
        self._now = sight.time
        hint = self._take_offers()
        if len(self._buttons.options) < len(self._offered):
            self._buttons.options, self._buttons.hint = tuple(self._offered), hint
        mode, since = sight.mode, sight.time - self._since
        lost = mode is None or not mode.nominal
        if lost:
            self._left = sight.time
        if not self._fault:
            return
        heading = f"<b>{html.escape(self._fault)}</b> {faint(duration(since) + ' ago')}"
        if self._story:
            story = self._story
        elif lost:
            story = f"now flying {mode_badge(mode)} {html.escape(sight.reason)}"
        elif self._left > self._since:
            lasted = duration(self._left - self._since)
            story = self._story = f"{badge('recovered', CALM)} after {lasted}"
        elif since > PATIENCE:
            story = self._story = "no fallback was needed"
        else:
            story = "no fallback so far"
        self._told.content, self._told.visible = block(heading, story), True


SPAN = 60.0  # s
OURS = "flown"


class Compare(SteeringPart):
    """Folded: the checkbox, and a table with the error of now and the RMS of the last minute."""

    name = "compare"
    title = "Compare"
    order = 40.0

    @classmethod
    def fits(cls, flight: WatchedFlight, source: FlightSource) -> bool:
        """Whether laws can be flown beside.

        Args:
            flight: What is compared.
            source: Where it comes from.
        """
        return flight.steering is not None and flight.steering.comparable

    def add(self) -> None:
        """Add the checkbox."""
        super().add()
        with self.folder:
            self._wanted: Any = self.gui.add_checkbox(
                "classical laws",
                False,
                hint="They begin where the aircraft is, in the same air about the same target.",
            )
            self._table = self.gui.add_html("", visible=False)
        self._wanted.on_update(self._ask)

    def _ask(self, event: Any) -> None:
        if event.client is None:  # this program has set it
            return
        self.client = event.client
        # As it is when those before it are answered: of two hands the last one counts.
        self.ask("laws beside", lambda: self.steering.compare(self._wanted.value), self._put_back)

    def _put_back(self, refusal: str) -> None:
        if refusal:
            self._wanted.value = not self._wanted.value

    def show(self, sight: Sight) -> None:
        """Write the errors.

        Args:
            sight: Of this aircraft.
        """
        self._table.visible = bool(sight.rivals)
        if not sight.rivals:
            return
        laws = tuple(rival.law for rival in sight.rivals)
        _, *past = columns(self.flight, sight, SPAN, lambda seen: _errors(seen, laws))
        rows = [
            (name, number(now, signed=True), number(_rms(each)))
            for name, now, each in zip((OURS, *laws), _errors(sight, laws), past, strict=True)
        ]
        self._table.content = block(table(rows, ("range error in m", "now", "RMS, last minute")))


def _errors(seen: Sight, laws: tuple[str, ...]) -> tuple[float, ...]:
    """Ours, then theirs; nan where one was not flown."""
    theirs = {rival.law: rival.range_error for rival in seen.rivals}
    ours = seen.errors.get("range_error", math.nan) if theirs else math.nan
    return ours, *(theirs.get(law, math.nan) for law in laws)


def _rms(errors: np.ndarray) -> float:
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else math.nan
