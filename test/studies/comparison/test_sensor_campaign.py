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

"""Random flights: a sensor that fails is named, no other is, and airspeed limits are kept."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from sensor_flights import FAULTS, judged

LONG = pytest.mark.long
SOON = 40.0  # s, after which a sensor fails in the suite


@pytest.mark.parametrize(
    "name", ["off", *(pytest.param(name, marks=LONG) for name in ("", "turned", "moved"))]
)
def test_what_fails_is_named_and_nothing_else(name):
    assert judged(1, name, begin=SOON)


@LONG  # what test_failing_sensors.py flies in gusts blames no airspeed either
@pytest.mark.parametrize("seed", [428, 434])
def test_gusts_along_a_rigid_aircraft_are_no_fault_of_its_airspeed(seed):
    """They show as airspeed before they move it; those across it show hardly."""
    pytest.importorskip("jsbsim")
    assert judged(seed, "", "jsbsim")


@pytest.mark.parametrize(
    ("seed", "name"),
    [
        (1003, "held"),
        pytest.param(1013, "reversed", marks=LONG),
        pytest.param(1018, "off", marks=LONG),
        pytest.param(1003, "still", marks=LONG),
        pytest.param(1004, "reversed", marks=LONG),
    ],
)
def test_a_rigid_aircraft_flies_on_whatever_fails(seed, name):
    """A heading and a velocity that are stuck; velocities of the wrong sign; an airspeed too high.

    The climb is no more known then; and nobody knows for 20 s which of the two is wrong.
    """
    pytest.importorskip("jsbsim")
    assert judged(seed, name, "jsbsim", SOON)


@LONG
def test_of_200_flights_none_is_blamed_and_of_200_faults_19_in_20_are_named():
    jobs = [(seed, "") for seed in range(200)]
    jobs += [(200 + k, list(FAULTS)[k % len(FAULTS)]) for k in range(200)]
    jobs += [(400 + k, "", "jsbsim") for k in range(40)]
    jobs += [(1000 + k, list(FAULTS)[k % len(FAULTS)], "jsbsim") for k in range(90)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        flown = [pool.submit(judged, *job) for job in jobs]
    beyond = [each.exception() for each in flown if each.exception()]
    right = [not each.exception() and each.result() for each in flown]
    without, failing, rigid, broken = right[:200], right[200:400], right[400:440], right[440:]
    print(f"rightly named: {sum(without)} of 200 without, {sum(failing)} of 200 with a fault")
    print(f"on six degrees of freedom without a fault: {sum(rigid)} of {len(rigid)}")
    print(f"on six degrees of freedom with a fault: {sum(broken)} of {len(broken)}")
    assert not beyond
    assert all(without + rigid)
    assert sum(failing) >= 190
    assert sum(broken) >= 85
