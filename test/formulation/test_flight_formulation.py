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
from itertools import islice

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.estimation.situation import Situation, steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FAR, GENTLER, FlightFormulation
from uav_tracking_mpc.mpc.solver import Solution, Status, solutions
from uav_tracking_mpc.parameters.specification import taken
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.tracking import FlightParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.feasibility_study import flight_start

FLIGHT = small_uav.parameters()
N, AIRSPEED_MAX = FLIGHT.horizon, FLIGHT.airspeed_max


def formulation(parameters=FLIGHT):
    return FlightFormulation(parameters, small_uav.solver())


def plan_of(flight, now, orbit=FLIGHT.orbit, elapsed=None, forecast=None):
    return flight.solve(now, forecast or steady_forecast(now, N), orbit, elapsed)


class Asked:
    """A solver that keeps what it is asked and answers nothing."""

    name, problem = "asked", None

    def solve(self, initial_state, parameters=None, elapsed=None, guess=None):
        self.state, self.data = np.array(initial_state), np.array(parameters)
        self.guess = guess()
        raise RuntimeError("this solver answers nothing")


def guess_of(now, orbit=FLIGHT.orbit, parameters=FLIGHT):
    asked = Asked()
    with pytest.raises(RuntimeError, match="answers nothing"):
        plan_of(FlightFormulation(parameters, asked), now, orbit)
    return asked


def test_the_flight_parameters_alone_pose_the_problem():
    own, now = formulation(taken(FlightParameters, FLIGHT)), small_uav.situation()
    np.testing.assert_array_equal(plan_of(own, now).inputs, plan_of(formulation(), now).inputs)


@pytest.mark.parametrize(("wanted", "above"), [("range=1e5", 0.0), ("altitude=1e4", 30.0)])
def test_the_farthest_and_the_highest_orbit_that_can_be_asked_for_are_flown(wanted, above):
    parameters = small_uav.parameters("range=10100.0", wanted)
    orbit, north = parameters.orbit, parameters.orbit.sense * 0.5 * np.pi
    vehicle = np.array([orbit.radius + 30.0, 0.0, orbit.altitude + above, north, 0.0, 22.0])
    there = Situation(vehicle, *np.zeros((4, 3)))
    plan = plan_of(formulation(parameters), there, orbit)
    assert plan.solution.converged
    assert plan.orbit[:2] == pytest.approx([orbit.range, orbit.altitude], abs=50.0)


def test_the_guess_is_a_flight_that_leads_to_an_orbit_that_can_be_flown():
    for now in small_uav.random_situations(10, seed=8):
        inputs, decision = guess_of(now).guess
        assert inputs.shape == (N, 3) and np.all(np.abs(inputs) <= 1.0)
        radius, _, speed = decision * [100.0, 30.0, 3.0]
        assert FLIGHT.airspeed_min <= speed <= FLIGHT.airspeed_max
        assert radius >= 1.05 * FLIGHT.envelope.smallest_radius(speed, now.drift)


@pytest.mark.parametrize("place", range(6))
def test_there_is_no_guess_where_the_situation_is_not_finite(place):
    vehicle = [300.0, 0.0, 120.0, 0.0, 0.0, 22.0]
    vehicle[place] = np.nan
    assert guess_of(small_uav.situation(*vehicle)).guess is None


def test_a_state_that_is_not_finite_is_refused_and_the_last_plan_kept():
    flight = formulation()
    now = small_uav.situation()
    before = plan_of(flight, now)
    unknown = small_uav.situation(np.nan)
    assert plan_of(flight, unknown, elapsed=0.05).solution.status is Status.REFUSED
    after = plan_of(flight, now, elapsed=0.0)
    assert after.solution.converged
    assert after.solution.iterations <= min(3, before.solution.iterations)


@pytest.mark.parametrize(
    ("drift", "words"),
    [
        (0.0, f"no plan of {FLIGHT.horizon * FLIGHT.horizon_step:g} s ends on an orbit"),
        (-40.0, f"the target moves through the air at 40 m/s, the aircraft at {AIRSPEED_MAX:g}"),
    ],
)
def test_a_plan_that_cannot_end_on_an_orbit_says_so(drift, words, monkeypatch):
    flight, problem = formulation(), small_uav.solver().problem
    found = Solution.without_plan(problem, Status.TIME_LIMIT, "gradient 0.5", 0.03)
    found = found._replace(violation=2.0)
    monkeypatch.setattr(flight.solver, "solve", lambda *where: found)
    now = replace(small_uav.situation(), drift=np.array([drift, 0.0, 0.0]))
    assert plan_of(flight, now).solution.message == f"{words}: {found.message}"


def test_the_plan_is_that_of_the_target_ahead():
    """A target that will stand still: what matters is where it is at each stage, not its speed."""
    now = small_uav.situation(target=(1000.0, 500.0, 30.0))
    here = plan_of(formulation(), now)
    there = plan_of(formulation(), small_uav.situation())
    np.testing.assert_allclose(here.inputs, there.inputs, atol=1e-7)
    assert here.step == FLIGHT.horizon_step


def test_left_and_right_are_mirror_images():
    drift, rates = (5.0, 3.0, 0.0), (0.1, 0.02, 0.3)
    now = small_uav.situation(350.0, 60.0, 100.0, 2.5, 0.05, 23.0, drift=drift, rates=rates)
    mirrored = small_uav.situation(
        350.0, -60.0, 100.0, -2.5, 0.05, 23.0, drift=(5.0, -3.0, 0.0), rates=(-0.1, 0.02, 0.3)
    )
    right = plan_of(formulation(), now, replace(FLIGHT.orbit, direction=CLOCKWISE))
    left = plan_of(formulation(), mirrored, replace(FLIGHT.orbit, direction=COUNTER_CLOCKWISE))
    np.testing.assert_allclose(right.inputs, left.inputs * [-1.0, 1.0, 1.0], atol=2e-4)


def test_the_floor_is_kept_over_a_target_that_is_below_it():
    """An orbit 40 m above a target at -20 m, least height 30 m: it flies at 30 m."""
    parameters = replace(FLIGHT, range=280.0, altitude=40.0, direction=COUNTER_CLOCKWISE)
    radius = parameters.orbit.radius
    now = small_uav.situation(radius, 0.0, 51.0, np.pi / 2.0, target=(0.0, 0.0, -20.0))
    plan = plan_of(formulation(parameters), now, parameters.orbit)
    assert plan.solution.converged
    heights = plan.solution.states[:, 2] - 20.0
    assert heights.min() > 30.0 - 1e-3
    assert heights[-1] == pytest.approx(30.0, abs=0.1)


def test_the_fence_is_kept_though_the_orbit_reaches_beyond():
    """A fence of 350 m about the target, and an orbit of 420 m asked for."""
    parameters = replace(FLIGHT, range=420.0, altitude=120.0, direction=COUNTER_CLOCKWISE)
    fenced = replace(parameters, fence_radius=350.0, fence_centre=(1000.0, 0.0))
    now = small_uav.situation(300.0, 0.0, 120.0, np.pi / 2.0, target=(1000.0, 0.0, 0.0))
    free = plan_of(formulation(parameters), now, parameters.orbit).solution
    kept = plan_of(formulation(fenced), now, parameters.orbit).solution
    assert free.converged and kept.converged
    farthest = [np.hypot(*solution.states[:, :2].T).max() for solution in (free, kept)]
    assert farthest[0] > 352.0
    assert 340.0 < farthest[1] < 350.0 + 0.01


def test_changes_reach_the_solver():
    flight = formulation()
    now = small_uav.on_orbit(FLIGHT, 0.0, -1.0)
    flight.change(replace(FLIGHT, solve_time_max=0.07, pitch_rate_max=0.01))
    assert flight.solver.time_limit == 0.07
    flight.change(replace(FLIGHT, pitch_rate_max=0.01))
    higher = replace(FLIGHT.orbit, altitude=150.0)
    assert np.abs(plan_of(flight, now, higher).inputs[:, 1]).max() <= 0.01 + 1e-12


def test_ipopt_is_made_when_asked_for():
    assert FlightFormulation(replace(FLIGHT, solver="ipopt", horizon=2)).solver.name == "ipopt"


def test_the_way_to_the_orbit_takes_few_iterations():
    """Roll rates are at their limit for most of it, which must not cost Newton its steps."""
    configuration = load_configuration("small_uav")
    formulation = FlightFormulation(small_uav.parameters())
    begin = Situation(configuration.simulator.initial_state, *np.zeros((4, 3)))
    start = flight_start(formulation, begin)
    loop = solutions(formulation.solver, start.state, start.parameters, start.guess)
    cold, *warm = islice(loop, 30)
    assert all(solution.converged for solution in [cold, *warm])
    iterations = [solution.iterations for solution in warm]
    assert np.median(iterations) <= 8
    assert max(iterations) <= 32


def test_the_way_in_leads_to_the_height_of_the_orbit_without_a_dive():
    """A dive gains range to a target on the ground, for which height counts for little."""
    configuration = load_configuration("small_uav", ["mission.duration=20"])
    log = simulate(configuration)
    heights, orbit = log.vehicle[:, 2], configuration.controller.orbit
    assert heights[0] < orbit.altitude - 10.0
    assert heights.min() > heights[0] - 0.5
    assert heights.max() < orbit.altitude + 0.5
    assert log.relative[-1, 0] == pytest.approx(orbit.range, abs=1.0)


@pytest.mark.parametrize(("error", "share"), [(0.0, 1.0), (FAR, 0.5), (-FAR, 0.5), (0.9, 0.0)])
def test_away_from_the_orbit_height_is_no_range_and_changes_are_gentler(error, share):
    where = FlightFormulation(FLIGHT, Asked()).flight.where
    slant = (1.0 + error) * FLIGHT.range
    now = small_uav.situation(np.sqrt(slant**2 - 120.0**2), 0.0, 120.0)
    data = guess_of(now).data[0]
    assert data[where["slant"]] == pytest.approx(share, abs=0.01)
    weights = data[where["rate_weights"]] / FLIGHT.rate_weights
    expected = [1.0, *[1.0 + GENTLER * (1.0 - share)] * 2]
    np.testing.assert_allclose(weights, expected, rtol=0.01)
