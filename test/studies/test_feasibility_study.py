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

"""What is guaranteed of the artificial orbit, random flights, and the campaign that shows it."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleState
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.feasibility_study import (
    COUNTED,
    GUARANTEED,
    NOT_GUARANTEED,
    campaign,
    feasibility_study,
    flight_start,
    random_situations,
    summary,
)

RADIUS, SPEED, STEP, LAG = 275.0, 22.0, 0.5, (0.3, 0.13, 0.16)


def test_steady_inputs_stay_on_the_orbit_without_drift():
    turn = SPEED / RADIUS
    state = VehicleState(RADIUS, 0.0, 120.0, np.pi / 2, 0.0, SPEED, turn, 0.0, 0.0)
    model, still = Lagged(LAG), Drift(np.zeros(3), np.zeros(3))
    for _ in range(200):
        state = model.step(state, [turn, 0.0, 0.0], STEP, model.numbers(STEP), still)
    assert np.hypot(state.x, state.y) == pytest.approx(RADIUS, abs=1e-4)
    assert state.turn_rate == pytest.approx(turn)


def test_the_words_hold_every_sentence():
    text = "\n".join(feasibility_study(load_configuration("small_uav")).words)
    for words in (*GUARANTEED, *NOT_GUARANTEED):
        assert words in text


PARAMETERS = load_configuration("small_uav").controller


def test_states_are_inside_the_envelope_and_everywhere():
    situations = random_situations(PARAMETERS, 2000)
    vehicles = np.array([each.vehicle for each in situations])
    ranges = np.linalg.norm(vehicles[:, :3], axis=1)
    assert ranges.min() >= PARAMETERS.distance_min - 1e-9
    assert ranges.max() > 900.0
    assert vehicles[:, 2].min() >= PARAMETERS.height_min - 1e-9
    assert 14.0 <= vehicles[:, 5].min() <= vehicles[:, 5].max() <= 32.0
    turns = np.array([each.rates[0] for each in situations])
    assert np.all(np.abs(turns * vehicles[:, 5] / GRAVITY) <= np.tan(PARAMETERS.bank_max) + 1e-9)
    drifts = np.array([np.linalg.norm(each.drift) for each in situations])
    assert np.all(drifts <= 0.4 * np.minimum(vehicles[:, 5], 22.0) + 1e-9)
    assert 0.25 < np.mean(drifts == 0.0) < 0.35
    assert drifts.max() > 8.0


def test_states_are_those_of_the_seed():
    first, again, other = (random_situations(PARAMETERS, 3, seed)[2].vehicle for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_twelve_states():
    situations = random_situations(PARAMETERS, 12, seed=3)
    counts = summary(campaign(PARAMETERS, situations, steps=30, workers=1, show=False))
    assert counts["states"] == 12
    assert counts["cold_failures"] == 0
    assert counts["steps"] == counts["converged"] == counts["feasible"] == 12 * 30
    assert counts["cost_rises"] == 0
    still = counts["without_drift"]
    assert 0 < still["states"] < 12
    assert still["feasible"] == still["steps"]
    assert 0.0 < counts["warm_us"]["median"] <= counts["warm_us"]["p99"]


def flight(drifting, counts, worst_rise, cold, warm):
    rest = {"worst_rise": worst_rise, "cold": cold, "warm": warm}
    return {"drifting": drifting, **dict(zip(COUNTED, counts, strict=True)), **rest}


def test_sums():
    good = flight(False, (0, 3, 3, 3, 0), 0.0, 1e-4, [1e-5, 2e-5])
    bad = flight(True, (1, 1, 0, 0, 0), 0.0, 3e-4, [])
    rising = flight(True, (0, 3, 3, 2, 1), 0.5, 2e-4, [3e-5, 4e-5])
    counts = summary([good, bad, rising])
    assert counts["states"] == 3
    assert [counts[name] for name in COUNTED] == [1, 7, 6, 5, 1]
    assert counts["worst_rise"] == 0.5
    assert counts["cold_us"]["median"] == pytest.approx(200.0)
    assert counts["warm_us"]["median"] == pytest.approx(25.0)
    assert counts["without_drift"]["cost_rises"] == 0
    assert summary([])["warm_us"] == {"median": None, "p99": None}


@pytest.mark.parametrize(
    ("vehicle", "wind", "turn_rate"),
    [
        ((118.384, -686.401, 132.0, 0.878271, -0.121208, 28.9703), (-5.27782, 1.23583), -0.232507),
        (
            (-357.002, 543.012, 129.632, -1.63204, -0.0509808, 31.7371),
            (-0.21172, 0.06444),
            0.269491,
        ),
    ],
)
def test_a_guess_that_must_turn_half_a_circle_does_not_end_on_the_wrong_side(
    vehicle, wind, turn_rate
):
    formulation = FlightFormulation(dataclasses.replace(PARAMETERS, solve_time_max=10.0))
    drift, rates = np.array([*wind, 0.0]), np.array([turn_rate, 0.0, 0.0])
    situation = Situation(np.array(vehicle), np.zeros(3), drift, np.zeros(3), rates)
    start = flight_start(formulation, situation)
    plan = formulation.solver.solve(
        start.state, start.parameters, None, lambda: start.guess(start.state)
    )
    assert plan.converged
    assert plan.violation < 1e-6
