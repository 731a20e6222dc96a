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

"""Every motion passes the check and moves as it says; the check finds what an author gets wrong."""

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


class Tuples(Line):
    def position(self, time):
        return tuple(super().position(time))


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
        (Tuples, "line: TypeError: unsupported operand"),
        (Shared, "depends on more than the time"),
    ],
)
def test_what_is_wrong_is_said(motion, words):
    with np.errstate(all="ignore"), pytest.raises(ConformanceError, match=words):
        check_motion(motion)


CORNERS = (0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 30.0, 40.0, 0.0)
JUMP = {"motion": "jump", "jump_time": 10.0, "jump_offset": (-100.0, 50.0, 5.0)}
STOP_AND_GO = {"motion": "stop_and_go", "drive_time": 4.0, "stand_time": 3.0}
WAYPOINTS = {"motion": "waypoints", "waypoints": CORNERS}
WEAVING = {"motion": "weaving", "weave_speed": 3.0, "weave_period": 8.0}
ROUND = {"motion": "circle", "speed": np.pi, "radius": 1.0, "heading": np.pi / 2}


@pytest.mark.parametrize(
    ("motion", "time", "position", "velocity"),
    [
        ({"motion": "stationary"}, 9.0, [1, 2, 3], [0, 0, 0]),
        ({"motion": "line", "heading": np.pi / 2}, 4.0, [1, 22, 3], [0, 5, 0]),
        (JUMP, 10.0 - 1e-9, [51, 2, 3], [5, 0, 0]),
        (JUMP, 10.0, [-49, 52, 8], [5, 0, 0]),
        (JUMP, 11.0, [-44, 52, 8], [5, 0, 0]),
        (STOP_AND_GO, 0.0, [1, 2, 3], [5, 0, 0]),
        (STOP_AND_GO, 4.0, [21, 2, 3], [0, 0, 0]),
        (STOP_AND_GO, 7.0, [21, 2, 3], [5, 0, 0]),
        (STOP_AND_GO, 8.0, [26, 2, 3], [5, 0, 0]),
        (STOP_AND_GO, 18.0, [61, 2, 3], [0, 0, 0]),
        (WEAVING, 2.0, None, [5, 3, 0]),
        (WEAVING, 8.0, [41, 2, 3], [5, 0, 0]),
        (ROUND, 0.0, [1, 3, 3], [-np.pi, 0, 0]),
        (ROUND, 0.5, [0, 2, 3], [0, -np.pi, 0]),  # counter-clockwise
        (WAYPOINTS, 0.0, [0, 0, 0], [5, 0, 0]),
        (WAYPOINTS, 6.0, [30, 0, 0], [0, 5, 0]),  # at a corner the velocity is that after it
        (WAYPOINTS, 13.9, None, [0, 5, 0]),
        (WAYPOINTS, 14.0, [30, 40, 0], [-3, -4, 0]),
        (WAYPOINTS, 24.0, [0, 0, 0], [5, 0, 0]),
    ],
)
def test_each_moves_as_it_says(motion, time, position, velocity):
    target = motion_of(TargetParameters(**{"position": (1.0, 2.0, 3.0), "speed": 5.0, **motion}))
    if position is not None:
        np.testing.assert_allclose(target.position(time), position, atol=1e-6)
    np.testing.assert_allclose(target.velocity(time), velocity, atol=1e-12)
