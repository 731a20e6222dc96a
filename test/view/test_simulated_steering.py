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

"""Guidance laws beside a simulated flight: from its place, in its air, about its target."""

import numpy as np
import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.view.simulated_steering import InterruptedLoop, Rival, Rivals, law_names

SETTINGS = ["nmpc_controller.law=l1", "mission.duration=5.0"]  # a leader that is quick to fly


@pytest.fixture
def leader():
    loop = InterruptedLoop(load_configuration("small_uav", SETTINGS, "crosswind"))
    for _ in range(100):
        loop.tick()
    return loop


def fly(leader, rivals, seconds):
    for _ in range(round(seconds * leader.rate)):
        leader.tick()
        seen = rivals.follow()
    return {rival.law: rival for rival in seen}


def test_they_begin_where_the_aircraft_is(leader):
    place, rivals = leader.plant.truth.position, Rivals(leader)
    rivals.fly(True)
    seen = fly(leader, rivals, 1.0 / leader.rate)
    assert set(seen) == set(law_names())
    for rival in seen.values():
        np.testing.assert_allclose(rival.position, place, atol=1e-6)


def test_one_that_fails_is_left_behind_whatever_it_raises(leader, monkeypatch):
    rivals = Rivals(leader)
    rivals.fly(True)
    follow = Rival.follow

    def failing(rival):
        if rival.law == "l1":
            raise RuntimeError("of a user's plant")
        return follow(rival)

    monkeypatch.setattr(Rival, "follow", failing)
    assert set(fly(leader, rivals, 1.0 / leader.rate)) == set(law_names()) - {"l1"}


def test_the_law_that_is_flown_is_its_own_rival(leader):
    """In the same air about the same target it flies the same."""
    rival = Rival("l1", leader)
    for _ in range(200):
        tick = leader.tick()
        seen = rival.follow()
    assert np.linalg.norm(seen.position - tick.truth.position) < 1.0


def test_wind_target_and_orbit_are_followed(leader):
    rivals = Rivals(leader)
    rivals.fly(True)
    leader.controller.change(range=350.0)
    leader.plant.change(
        load_configuration("small_uav", [*SETTINGS, "uav_simulator.wind=[0.0,-6.0,0.0]"]).simulator
    )
    leader.target.go_to(leader.time, (40.0, 20.0, 0.0))
    seen = fly(leader, rivals, 40.0)
    target = leader.target.position(leader.time)
    for rival in seen.values():
        assert abs(rival.range_error) < 10.0
        assert np.linalg.norm(rival.position - target) == pytest.approx(350.0, abs=12.0)


def test_a_reset_brings_them_back_too_and_an_end_ends_them(leader):
    rivals = Rivals(leader)
    rivals.fly(True)
    fly(leader, rivals, 5.0)
    leader.reset()
    start = leader.plant.truth.position
    seen = fly(leader, rivals, 0.5)
    for rival in seen.values():
        assert np.linalg.norm(rival.position - start) < 25.0
    rivals.fly(False)
    assert rivals.follow() == ()


def test_the_flight_that_is_compared_is_the_same_as_ever():
    configuration = load_configuration("small_uav", SETTINGS, "gusts")
    alone = simulate(configuration)
    loop = InterruptedLoop(configuration)
    rivals = Rivals(loop)
    rivals.fly(True)
    fly(loop, rivals, 5.0)
    np.testing.assert_array_equal(loop.log(5.0).vehicle, alone.vehicle)
