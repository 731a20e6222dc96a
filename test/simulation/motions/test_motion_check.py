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

"""Every motion passes the check, and the check finds what an author gets wrong."""

import numpy as np
import pytest

from uav_tracking_mpc.parameters.conformance import ConformanceError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import TARGET_MOTION, motion_of
from uav_tracking_mpc.simulation.motions.conformance import check_motion
from uav_tracking_mpc.simulation.motions.straight import Line


@pytest.mark.parametrize("name", TARGET_MOTION.names)
def test_every_motion_passes(name):
    check_motion(TARGET_MOTION.find(name))


def test_the_parameters_name_the_motion():
    assert isinstance(motion_of(TargetParameters(motion="line")), Line)
    with pytest.raises(ParameterError, match="'swim', must be one of circle, jump, line"):
        motion_of(TargetParameters(motion="swim"))


class Nameless(Line):
    name = ""


class Short(Line):
    def position(self, time):
        return super().position(time)[:2]


class Infinite(Line):
    def velocity(self, time):
        return super().velocity(time) / 0.0 if time > 50.1 else super().velocity(time)


class Knots(Line):
    """A position in [m] and a velocity in other units."""

    def velocity(self, time):
        return super().velocity(time) / 0.5144


class Stateful(Line):
    """Moves on at every question."""

    asked = 0

    def position(self, time):
        self.asked += 1
        return super().position(time) + 1e-3 * self.asked


class Shared(Line):
    """Hands out its own array: whoever changes it moves the target."""

    def position(self, time):
        return self._start

    def velocity(self, time):
        return np.zeros(3)


@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (Nameless, "Nameless has no `name`"),
        (Short, r"position\(0\) \[m\] has shape \(2,\), must have \(3,\)"),
        (Infinite, r"velocity\(50.25\) \[m/s\] is .*inf.*must be finite"),
        (Knots, r"velocity\(0\) is \[9.7.*the position moves with \[5"),
        (Stateful, "the position moves with|depends on more than the time"),
        (Shared, "depends on more than the time"),
    ],
)
def test_what_is_wrong_is_said(motion, words):
    with np.errstate(all="ignore"), pytest.raises(ConformanceError, match=words):
        check_motion(motion)
