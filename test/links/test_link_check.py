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

"""Every link that needs no aircraft passes the check, and it finds what an author gets wrong."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.links._check import check_link
from uav_tracking_mpc.links.simulated import SimulatedLink
from uav_tracking_mpc.parameters.conformance import ConformanceError


@pytest.mark.parametrize("plant", ["", "vehicle", "euler"])
def test_the_simulated_one_passes(plant):
    check_link(SimulatedLink, plant)


class Mute(SimulatedLink):
    when_silent = ""


class Deaf(SimulatedLink):
    def measured(self, timeout):
        super().measured(timeout)


class OtherClock(SimulatedLink):
    """Stamps of the autopilot's boot, not of our clock."""

    def measured(self, timeout):
        state = super().measured(timeout)
        return dataclasses.replace(state, stamp=state.stamp + 1e6)


class Careless(SimulatedLink):
    def command(self, stamp, inputs, step, orbit=None):
        super().command(stamp, inputs, step, orbit)
        return ""


class Hasty(SimulatedLink):
    def command(self, stamp, inputs, step, orbit=None):
        return "" if np.isfinite(inputs[0]).all() else "not finite"


class Clinging(SimulatedLink):
    def close(self):
        pass


class Forgetful(SimulatedLink):
    def measured(self, timeout):
        self._flown.advance(1.0 / 20.0)
        return self._flown.measured()


@pytest.mark.parametrize(
    ("link", "words"),
    [
        (Mute, "`when_silent` must say"),
        (Deaf, "no state within 2 s"),
        (OtherClock, r"stamps must be of now\(\)'s clock"),
        (Careless, "a plan that is not finite must be refused in words, it is accepted"),
        (Hasty, "a plan that is empty must be refused in words, it raises IndexError"),
        (Clinging, r"after close\(\) measured\(\) must raise LinkError, it gives"),
        (Forgetful, r"after close\(\) measured\(\) must raise LinkError, it raises AttributeError"),
    ],
)
def test_what_is_wrong_is_said(link, words):
    with pytest.raises(ConformanceError, match=words):
        check_link(link)
