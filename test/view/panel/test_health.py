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

"""Whether it is well, in words and by gauges."""

import math

import numpy as np
import pytest
from watched_flight_stand_in import sight

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.panel.health import Health, in_words, nearest_limit, worst_sensor
from uav_tracking_mpc.view.watched_flight import CONTROLLER, NodeStatus, TargetSight

TRACKING = load_configuration("small_uav").controller


def off(error):
    return sight(errors={"range_error": error})


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (off(0.4), "well: it is on the orbit"),
        (off(-312.3), "on its way to the orbit: 312 m to go"),
        (
            sight(errors={"range_error": 3.0, "altitude_error": -26.6}),
            "on its way to the orbit: 27 m to go",
        ),
        (sight(errors={}), "flies the best plan"),
        (sight(mode=None), "waits for its first command"),
        (
            sight(mode=FallbackMode.FEASIBLE, reason="time limit 0.05 s reached, gradient 0.862"),
            "flies plans that are safe, but cut short for time",
        ),
        (
            sight(mode=FallbackMode.LOITER, reason="target position is lost"),
            "circles by the loiter law, without a plan: target position is lost",
        ),
    ],
)
def test_one_line_says_how_it_is(seen, words):
    assert in_words(seen, TRACKING) == words


@pytest.mark.parametrize(
    ("more", "words", "used"),
    [
        ({"bank": math.radians(-40.0)}, "bank, 5.0 ° left", 40.0 / 45.0),
        ({"airspeed": 14.0}, "airspeed, 0.0 m/s left", 1.0),
        ({"position": np.array([275.0, 0.0, 31.0])}, "altitude, 1.0 m left", 30.0 / 31.0),
    ],
)
def test_the_nearest_limit_is_that_of_which_most_is_used(more, words, used):
    margin = nearest_limit(sight(**more), TRACKING)
    assert margin.words == words
    assert margin.used == pytest.approx(used)


def test_a_fence_is_a_limit():
    fenced = load_configuration("small_uav", ["nmpc_controller.fence_radius=400.0"]).controller
    margin = nearest_limit(sight(position=np.array([390.0, 0.0, 121.0])), fenced)
    assert margin.words == "fence, 10 m left"
    assert nearest_limit(sight(), None) is None


def sensors(**states):
    values = {f"{name} sensor": state for name, state in states.items()}
    target = TargetSight(np.zeros(3), std=2.0, measured=np.zeros(3))
    return sight(target=target, statuses=(NodeStatus(CONTROLLER, 0, "", values),))


def test_a_sensor_that_is_left_out_is_the_worst():
    margin = worst_sensor(sensors(airspeed="stuck", heading="used"), TRACKING)
    assert margin == ("airspeed: stuck, left out", 1.0)


def test_else_it_is_told_how_surely_the_target_is_known():
    margin = worst_sensor(sensors(airspeed="used", heading="used"), TRACKING)
    assert margin.words == "target, to 6.0 m"
    assert margin.used == pytest.approx(6.0 / 30.0)
    assert worst_sensor(sight(target=None), TRACKING).words == "target: not seen yet"
    assert worst_sensor(sight(), TRACKING) is None


def test_words_of_others_are_no_html(panel, flight):
    flight.seen = [sight(mode=FallbackMode.HOLD, reason="<img src=x>")]
    assert "<img" not in panel(Health).show()
