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

"""Changes of the sensors are told once, with what stands in for one that is left out."""

import pytest

from uav_tracking_mpc.estimation.sensor_health import (
    AIRSPEED,
    HEADING,
    JUMPED,
    OFF,
    POSITION,
    SILENT,
    USED,
    VELOCITY,
    SensorHealth,
)


@pytest.mark.parametrize(
    ("airspeed", "heading", "velocity"),
    [
        (USED, "ground velocity and wind stand in for it", "air velocity and wind stand in for it"),
        (
            SILENT,
            "the gyros carry the one before on",
            "positions alone tell how the aircraft moves",
        ),
    ],
)
def test_what_stands_in_depends_on_whether_there_is_an_airspeed(airspeed, heading, velocity):
    health = SensorHealth()
    health.states[AIRSPEED] = airspeed
    list(health.news())
    health.states.update({HEADING: JUMPED, VELOCITY: OFF})
    assert list(health.news()) == [
        f"heading has jumped: {heading}",
        f"ground velocity is off: {velocity}",
    ]
    assert not list(health.news())
    health.states[HEADING] = USED
    assert list(health.news()) == ["heading agrees with the others: it is used again"]


def test_of_a_position_that_is_used_again_nobody_says_that_the_others_agree():
    health = SensorHealth()
    health.states[POSITION] = JUMPED
    assert next(health.news()).startswith("position has jumped: the ground velocity")
    health.states[POSITION] = USED
    (words,) = health.news()
    assert words == "position agrees with the others, or has stayed where it is: it is used again"
