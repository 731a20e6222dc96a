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

from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.studies.comparison.scenarios import mismatched, variants

LONG = pytest.mark.long


@pytest.mark.parametrize(
    "name", ["", "off", pytest.param("turned", marks=LONG), pytest.param("moved", marks=LONG)]
)
def test_what_fails_is_named_and_nothing_else(name):
    assert judged(1, name)


@pytest.mark.parametrize("seed", [428, pytest.param(434, marks=LONG)])
def test_gusts_along_a_rigid_aircraft_are_no_fault_of_its_airspeed(seed):
    """They show as airspeed before they move it; those across it show hardly."""
    pytest.importorskip("jsbsim")
    assert judged(seed, "", "jsbsim")


@LONG
def test_gusts_on_a_straight_way_in_blame_no_sensor():
    """All that is known of the wind then comes from one direction."""
    for case in variants(mismatched("small_uav", "gust_light"), "gust_light"):
        loop = ClosedLoop(case)
        while loop.time < 40.0:
            loop.tick()
        log = loop.log(40.0)
        assert not log.sensors
        assert abs(log.error[-1, 0]) < 3.0


@LONG
def test_of_200_flights_none_is_blamed_and_of_200_faults_19_in_20_are_named():
    jobs = [(seed, "") for seed in range(200)]
    jobs += [(200 + k, list(FAULTS)[k % len(FAULTS)]) for k in range(200)]
    jobs += [(400 + k, "", "jsbsim") for k in range(40)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        flown = [pool.submit(judged, *job) for job in jobs]
    beyond = [each.exception() for each in flown if each.exception()]
    right = [not each.exception() and each.result() for each in flown]
    without, failing, rigid = right[:200], right[200:400], right[400:]
    print(f"rightly named: {sum(without)} of 200 without, {sum(failing)} of 200 with a fault")
    print(f"on six degrees of freedom without a fault: {sum(rigid)} of {len(rigid)}")
    assert not beyond
    assert all(without + rigid)
    assert sum(failing) >= 190
