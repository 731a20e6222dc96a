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

"""Every plant passes the check, and the check finds what an author gets wrong."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.parameters.conformance import ConformanceError
from uav_tracking_mpc.simulation.plants import PLANT
from uav_tracking_mpc.simulation.plants.conformance import check_plant
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant


@pytest.mark.parametrize("name", PLANT.names)
def test_every_plant_passes(name):
    check_plant(PLANT.find(name))


class Degrees(VehiclePlant):
    @property
    def truth(self):
        truth = super().truth
        return dataclasses.replace(truth, heading=np.degrees(truth.heading))


class Gullible(VehiclePlant):
    def accept(self, inputs, starts):
        if np.shape(inputs) == (1, 2):
            return
        super().accept(inputs, starts)


class Random(VehiclePlant):
    def advance(self, duration):
        super().advance(duration)
        self.state[0] += np.random.default_rng().normal() * (duration > 0.0)


class Frozen(VehiclePlant):
    def advance(self, duration):
        self.time += duration


class Timeless(VehiclePlant):
    def advance(self, duration):
        before = self.time
        super().advance(duration)
        self.time = before


class Diverging(VehiclePlant):
    def advance(self, duration):
        super().advance(duration)
        self.state[2] = np.inf if self.time > 1.0 else self.state[2]


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (Degrees, r"truth at 0.05 s: heading is .*are the units right"),
        (Gullible, "a plan of the wrong shape is taken, must raise ValueError"),
        (Random, "differs from that of another with its seed"),
        (Frozen, "has not moved"),
        (Timeless, "has the stamp 0.0 s after 1 steps of 0.05 s"),
        (Diverging, "position is .*inf.*, must be three finite numbers"),
    ],
)
def test_what_is_wrong_is_said(plant, words):
    with pytest.raises(ConformanceError, match=words):
        check_plant(plant)
