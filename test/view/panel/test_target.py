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

import pytest
from watched_flight_stand_in import StandInFlight, StandInSource, StandInSteering

from uav_tracking_mpc.parameters.registry import TARGET_MOTION
from uav_tracking_mpc.view.panel.target import Target
from uav_tracking_mpc.view.steering import CONTROLLER, TARGET


@pytest.fixture
def target(panel):
    shown = panel(Target)
    shown.until(lambda: "motion" in shown.labels())
    return shown


def test_every_motion_is_listed(target):
    assert set(target.widget("motion").options) == set(TARGET_MOTION.names)
    assert target.widget("motion").value == "stationary"


def test_motion_and_speed_are_sent_together(target, flight):
    target.by_hand("motion", "circle")
    target.by_hand("speed [m/s]", 5.0)
    target.until(lambda: flight.steering.asked)
    assert flight.steering.asked == [("change", TARGET, {"motion": "circle", "speed": 5.0})]


def test_a_motion_of_somebody_elses_file_is_shown(target, flight):
    flight.steering.values[TARGET] |= {"motion": "my_motion.py:Mine", "speed": 40.0}
    target.until(lambda: target.widget("motion").value == "my_motion.py:Mine")
    assert target.widget("speed [m/s]").value == 40.0


def test_a_target_that_is_tracked_is_not_steered():
    flight = StandInFlight(steering=StandInSteering([CONTROLLER]))
    assert not Target.fits(flight, StandInSource(flight))
