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

"""A vehicle link for tests: a plant in real time, that can be missing, refused and taken over."""

from __future__ import annotations

import time

import numpy as np

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection, LinkError, LinkRefusedError, Sighting
from uav_tracking_mpc.links.simulated import SimulatedLink
from uav_tracking_mpc.settings.configuration import load_configuration

LINK = f"{__file__}:PacedLink"  # as a parameter has it


class PacedLink(SimulatedLink):
    """What it does is told by its address: ``nobody``, ``copter``, ``tight``, ``slow`` or nothing.

    Attributes:
        orbits: Those that came with the commands.
        stamps: Of the commands, by the clock of :meth:`now`.
        refusal: What it answers to commands.
    """

    name = "paced"
    when_silent = "flies the last plan to its end"

    def __init__(self, address=""):
        super().__init__("", load_configuration("small_uav").simulator)
        self.address, self.orbits, self.stamps = address, [], []
        self.refusal, self._engaged, self._sighted = "", False, False
        self.closed = 0

    def connect(self, timeout):
        if self.address == "nobody":
            raise LinkError("nobody answers")
        if self.address == "copter":
            raise LinkRefusedError("it is a copter")
        address, self.address = self.address, ""
        super().connect(timeout)
        self.address = address
        self._begin = time.monotonic()

    def close(self):
        self.closed += 1
        super().close()

    def now(self):
        return time.monotonic()

    def measured(self, timeout):
        if self._flown is None:
            raise LinkError("not connected")
        due = self._begin + self.plant.time + 1.0 / self._parameters.state_rate
        time.sleep(max(0.0, due - time.monotonic()))
        seen = super().measured(timeout)
        values = {field: getattr(seen, field) for field in Measurement.__dataclass_fields__}
        return Measurement(**{**values, "stamp": self._begin + seen.stamp})

    def command(self, stamp, inputs, step, orbit=None):
        self.orbits.append(orbit)
        self.stamps.append(stamp)
        if self.refusal or not self._engaged:
            return self.refusal
        return super().command(stamp - self._begin, inputs, step, orbit)

    def inspect(self):
        bank = 0.1 if self.address == "tight" else 0.7
        refusals = ("disarmed",) if self.address == "disarmed" else ()
        envelope = {"bank_max": bank, "airspeed_min": 15.0, "height_min": 20.0}
        return Inspection({"firmware": "paced 1.0"}, envelope, ("no fence",), refusals)

    @property
    def engaged(self):
        return self._engaged

    def engage(self):
        if self.address == "stubborn":
            return "the pilot says no"
        self._engaged = True
        self.events.add(Level.INFO, "engaged")
        return ""

    def disengage(self):
        self._engaged = False

    def sighting(self):
        if self._sighted:
            return None
        self._sighted = True
        return Sighting(self.now(), np.array([1.0, 2.0, 3.0]), np.array([4.0, 0.0, 0.0]))

    def values(self):
        return {"rate [Hz]": 20.0, "messages lost": 3}
