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

"""What a flight is does not depend on what flew before it, or beside it."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from campaign_files import short_campaign

from uav_tracking_mpc.simulation import closed_loop
from uav_tracking_mpc.studies.campaign import one_flight
from uav_tracking_mpc.studies.campaign.flight_plan import planned
from uav_tracking_mpc.studies.campaign.one_flight import fly_batch, fly_one, shared_formulation

TASKS = [(number, "nmpc") for number in (0, 1, 4)]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    draw = {
        "mission.duration": 4.0,
        "start.distance": {"uniform": [290.0, 320.0]},
        "nmpc_controller.range": {"uniform": [250.0, 350.0]},
        "nmpc_controller.offset_weights[0]": {"uniform": [3.0, 5.0]},
        "wind.speed": {"uniform": [0.0, 8.0]},
    }
    folder = tmp_path_factory.mktemp("campaign")
    return short_campaign(folder, draw=draw, laws=["nmpc"], settled_after=2.0)


@pytest.fixture(scope="module")
def rows(campaign):
    """Of flights that each have a solver of their own."""
    flown = []
    for task in TASKS:
        one_flight._of_thread.kept = None
        flown.append(fly_one(campaign, *task))
    return flown


def test_flights_that_share_a_solver_are_bit_for_bit_those_that_do_not(campaign, rows):
    assert not any(row["error"] for row in rows)
    assert fly_batch(campaign, TASKS) == rows
    assert fly_batch(campaign, TASKS[::-1])[::-1] == rows


def test_one_formulation_serves_all_flights_of_a_thread(campaign):
    one, other = (planned(campaign, number).configuration("nmpc").controller for number in (0, 1))
    kept = shared_formulation(one)
    assert shared_formulation(other) is kept
    assert shared_formulation(planned(campaign, 0).configuration("l1").controller) is None
    assert shared_formulation(one) is kept


def test_two_flights_at_a_time(campaign, rows):
    """Threads share the compiled method and nothing that a solve writes to."""
    with ThreadPoolExecutor(2) as threads:
        flown = list(threads.map(lambda task: fly_one(campaign, *task), TASKS))
    assert flown == rows


def test_a_flight_that_raises_is_a_failure(campaign, monkeypatch):
    def broken(*arguments, **options):
        raise closed_loop.SimulationError("the wing is off")

    monkeypatch.setattr(one_flight, "simulate", broken)
    row = fly_one(campaign, 0, "nmpc")
    assert (row["failed"], row["reasons"]) == (True, "raised")
    assert row["error"] == "SimulationError: the wing is off"


def test_a_row_says_what_came_of_the_flight(rows):
    row = rows[0]
    assert row["group"] == "single"
    assert row["mistake"] == "lag"
    assert row["settled_s"] >= 2.0
    assert 0.0 <= row["range_rms_m"] <= row["worst_m"]
    assert row["worst_settled_m"] > 0.0
    assert row["uav_simulator.velocity_noise"] == 0.0
    assert row["target_publisher.motion"] == "stationary"
