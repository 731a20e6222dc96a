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

from dataclasses import replace

import numpy as np
import pytest
from example_flights import orbiting

from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.studies.campaign.criteria import Criteria

LIMITS = TrackingParameters(airspeed_min=2.0, airspeed_max=8.0, bank_max=0.6)
CRITERIA = Criteria(beyond=30.0, settled_for=20.0)
TIME = np.arange(0.0, 100.0, 0.5)


def error(*pieces):
    """Range error that is so large from each time on."""
    values = np.zeros_like(TIME)
    for begin, size in pieces:
        values[begin <= TIME] = size
    return values


@pytest.mark.parametrize(
    ("flown", "settled"),
    [
        (error(), 20.0),
        (error((0.0, 90.0), (40.0, -12.0)), 60.0),
        (error((0.0, 90.0), (10.0, 0.0), (20.0, 90.0), (50.0, 3.0)), 70.0),  # passing through
        (error((0.0, 90.0)), None),
        (error((0.0, 90.0), (95.0, 0.0)), None),
        (np.full_like(TIME, np.nan), None),
    ],
)
def test_settled_is_inside_for_long_enough(flown, settled):
    assert CRITERIA.settled_at(TIME, flown) == settled


@pytest.mark.parametrize(
    ("flown", "found"),
    [
        (error(), []),
        (error((0.0, 90.0)), ["never_settled"]),
        (error((60.0, 29.0)), []),
        (error((60.0, -31.0)), ["orbit_lost"]),
        (error((60.0, np.nan)), ["orbit_lost"]),
        (error((0.0, 90.0), (50.0, 0.0)), []),
    ],
)
def test_an_orbit_is_lost_after_settling(flown, found):
    log = orbiting(len(TIME), step=0.5)
    assert CRITERIA.failures(log, flown, LIMITS) == found


@pytest.mark.parametrize(
    ("speed", "limits", "found"),
    [
        (8.3, ("airspeed",), []),
        (8.5, ("airspeed",), ["limit_passed:airspeed"]),
        (1.8, ("airspeed", "bank"), ["limit_passed:airspeed"]),
        (8.5, ("path_angle",), []),
    ],
)
def test_a_limit_may_be_passed_by_a_share(speed, limits, found):
    log = orbiting(200, step=0.5)
    vehicle = log.vehicle.copy()
    vehicle[50, 5] = speed
    log = replace(log, vehicle=vehicle)
    criteria = Criteria(("limit_passed",), by=0.05, limits=limits)
    assert criteria.failures(log, log.error[:, 0], LIMITS) == found


def test_only_what_is_named_counts():
    log, lost = orbiting(len(TIME), step=0.5), error((60.0, 90.0))
    assert replace(CRITERIA, names=("never_settled",)).failures(log, lost, LIMITS) == []
