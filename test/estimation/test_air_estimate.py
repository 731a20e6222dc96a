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

"""Wind, gusts and biases from flights whose air is known."""

import math
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.estimation.air_check import WIND_KNOWN
from uav_tracking_mpc.estimation.air_estimate import AirEstimate
from uav_tracking_mpc.estimation.measurement import Axis, Measurement, SensorNoise
from uav_tracking_mpc.estimation.sensor_health import POSITION, USED
from uav_tracking_mpc.estimation.wind_filter import DIAGONAL, QUICK, SIZE, G, P, W, lasting_gust

SIZES = {"elapsed": 1, "gust": 3, "air": 3, "steady": 3}
STEP, SPEED, TURN = 0.05, 22.0, 0.073


class AirFilter(AirEstimate):
    """Estimate of an aircraft whose air velocity is measured as a vector.

    It turns as that does, if nobody says how.
    """

    def see(
        self, time, position, ground, air, noise=(0.0, 0.0, 0.0), velocity_noise=(0.0,) * 3,
        turn=None,
    ):  # fmt: skip
        east, north, up = np.asarray(air, dtype=float)
        heading, speed = math.atan2(north, east), math.hypot(east, north, up)
        if turn is None and self._time is not None and time > self._time:
            turn = math.remainder(heading - self._seen.heading[0], math.tau) / (time - self._time)
        told = SensorNoise(position=tuple(noise), velocity=tuple(velocity_noise))
        measurement = Measurement(
            time, position, ground, heading, math.asin(up / speed), turn or 0.0,
            airspeed=speed, noise=told, axis=Axis.AIR_VELOCITY,
        )  # fmt: skip
        rates = np.array([turn or 0.0, 0.0, 0.0])
        state = measurement.state(speed)
        self.update(measurement, state, rates, 0.0, False)


def flown(duration, **what):
    """Filter and position after so long a flight."""
    *_, last = flown_by_steps(duration, **what)
    return last


def flown_by_steps(
    duration, wind=(3.0, -5.0, 0.2), bias=(0.0, 0.0, 0.0), share=0.0, heading=0.0, noise=0.0,
    position_noise=(0.0, 0.0, 0.0), told=False, resolution=1e-9,
):  # fmt: skip
    """Filter and position after each step of circling in steady wind with sensors that err."""
    random, position = np.random.default_rng(2), np.array([100.0, 50.0, 120.0])
    filter_ = AirFilter()
    for k in range(round(duration / STEP)):
        psi = TURN * k * STEP
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        measured = (
            SPEED / (1.0 - share) * np.array([np.cos(psi + heading), np.sin(psi + heading), 0.0])
        )
        ground = air + wind + np.array(bias) + noise * random.standard_normal(3)
        place = position + np.array(position_noise) * random.standard_normal(3)
        place = resolution * np.round(place / resolution)
        known = (position_noise, (noise,) * 3) if told else ()
        filter_.see(k * STEP, place, ground, measured, *known)
        chord = STEP * np.sinc(0.5 * TURN * STEP / np.pi)
        middle = psi + 0.5 * TURN * STEP
        position = position + chord * SPEED * np.array([np.cos(middle), np.sin(middle), 0.0])
        position = position + STEP * np.array(wind)
        yield filter_, position


def test_in_steady_wind_everything_else_is_nothing():
    filter_, _ = flown(60.0)
    np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, [3.0, -5.0, 0.2], atol=5e-3)
    np.testing.assert_allclose(filter_.state.wind, [3.0, -5.0, 0.2], atol=0.1)
    np.testing.assert_allclose(filter_.state.bias, 0.0, atol=1e-2)
    assert abs(filter_.state.alpha[0]) < 1e-3
    assert abs(filter_.state.beta[0]) < 1e-3


def test_on_a_straight_way_the_wind_ahead_stays_unknown_without_the_airspeed():
    """So a sound airspeed stays in use, however long the way and however strong the wind."""
    filter_, (along, wind) = AirFilter(), np.array([[SPEED, 0.0, 0.0], [8.0, 0.0, 0.0]])
    for k in range(round(600.0 / STEP)):
        filter_.see(k * STEP, k * STEP * (along + wind), along + wind, along)
        assert filter_.found.vehicle[5] == pytest.approx(SPEED, abs=0.1)
    known = filter_.found.known[0]
    assert not known
    assert filter_.health.states["airspeed"] == "used"


def test_a_heading_that_jumps_before_the_wind_is_known_is_taken_back():
    """By the gyros: nothing else contradicts it yet, and what it says would become wind."""
    filter_, along, wind = AirFilter(), np.array([SPEED, 0.0, 0.0]), np.array([3.0, -5.0, 0.0])
    beside = SPEED * np.array([np.cos(1.5), np.sin(1.5), 0.0])
    for k in range(round(30.0 / STEP)):
        air = beside if k * STEP > 15.0 else along
        filter_.see(k * STEP, k * STEP * (along + wind), along + wind, air, turn=1e-4)
        assert filter_.health.states["heading"] == ("jumped" if k * STEP > 15.0 else "used")
        assert filter_.found.vehicle[3] == pytest.approx(0.0, abs=0.01)
        if k * STEP > 5.0:
            np.testing.assert_allclose(filter_.state.wind[:2], wind[:2], atol=0.3)


def test_a_heading_that_is_found_before_somebody_engages_is_believed():
    filter_, along, wind = AirFilter(), np.array([SPEED, 0.0, 0.0]), np.array([3.0, -5.0, 0.0])
    bogus = SPEED * np.array([np.cos(1.5), np.sin(1.5), 0.0])
    for k in range(round(30.0 / STEP)):
        if k == 400:
            filter_.trust_compass()
        found = k * STEP > 15.0
        filter_.see(
            k * STEP, k * STEP * (along + wind), along + wind, along if found else bogus, turn=1e-4
        )
    assert filter_.health.states["heading"] == "used"
    assert filter_.found.vehicle[3] == pytest.approx(0.0, abs=0.05)


def test_a_compass_that_is_aligned_on_the_ground_is_believed():
    filter_ = AirFilter()
    for k in range(1200):
        psi = 0.0 if k < 50 else 1.5
        nose = np.array([np.cos(psi), np.sin(psi), 0.0])
        filter_.see(k * STEP, np.zeros(3), np.zeros(3), nose, turn=1e-4)
    assert filter_.health.states["heading"] == "used"
    assert filter_.found.vehicle[3] == pytest.approx(1.5, abs=0.05)


@pytest.mark.parametrize("off", [8.0, -8.0])
def test_an_airspeed_that_leaps_before_the_wind_is_known_is_left_out_until_it_agrees(off):
    """No gust changes it as quickly; and what it has told of the wind before tells it meanwhile."""
    filter_, along, wind = AirFilter(), np.array([SPEED, 0.0, 0.0]), np.array([3.0, -5.0, 0.0])
    for k in range(round(40.0 / STEP)):
        wrong = 15.0 < k * STEP < 25.0
        air = along * (SPEED + off * wrong + 0.01 * math.sin(k)) / SPEED
        filter_.see(k * STEP, k * STEP * (along + wind), along + wind, air)
        assert filter_.found.vehicle[5] == pytest.approx(SPEED, abs=0.5)
        if not 25.0 <= k * STEP <= 33.0:
            assert filter_.health.states["airspeed"] == ("jumped" if wrong else "used")


def test_a_bias_of_the_ground_velocity_shows_beside_the_positions():
    filter_, _ = flown(20.0, bias=(2.0, -1.0, 0.5))
    np.testing.assert_allclose(filter_.state.bias, [2.0, -1.0, 0.5], atol=0.05)
    np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, [3.0, -5.0, 0.2], atol=0.05)


def test_a_ground_velocity_that_wanders_is_told_by_the_positions():
    """As PX4's does in vibration: 0.25 m/s to and fro in 12 s is no wind."""
    filter_, position, wind, wrong = AirFilter(), np.zeros(3), np.array([3.0, -5.0, 0.0]), []
    for k in range(round(100.0 / STEP)):
        psi, phase = TURN * k * STEP, 2.0 * np.pi * k * STEP / 12.0
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        wander = 0.25 * np.array([np.sin(phase), np.cos(phase), 0.0])
        filter_.see(k * STEP, position, air + wind + wander, air)
        wrong.append(filter_.state.wind + filter_.state.gust - wind)
        chord, middle = STEP * np.sinc(0.5 * TURN * STEP / np.pi), psi + 0.5 * TURN * STEP
        position = position + chord * SPEED * np.array([np.cos(middle), np.sin(middle), 0.0])
        position = position + STEP * wind
    lengths = np.linalg.norm(wrong[round(40.0 / STEP) :], axis=1)
    assert np.sqrt(np.mean(lengths**2)) < 0.2


@pytest.mark.parametrize(("share", "heading"), [(0.09, 0.0), (0.0, 0.087), (-0.05, -0.05)])
def test_biases_of_airspeed_and_heading_show_while_the_aircraft_turns(share, heading):
    filter_, _ = flown(200.0, share=share, heading=heading)
    assert filter_.state.alpha[0] == pytest.approx(share, abs=0.01)
    assert filter_.state.beta[0] == pytest.approx(heading, abs=0.01)
    np.testing.assert_allclose(filter_.state.wind, [3.0, -5.0, 0.2], atol=0.3)


@pytest.mark.parametrize("share", [0.3, -0.4])
def test_an_airspeed_that_is_far_off_from_the_start_is_corrected(share):
    filter_, _ = flown(300.0, share=share)
    assert filter_.found.vehicle[5] == pytest.approx(SPEED, abs=0.5)
    assert filter_.state.alpha[0] == pytest.approx(share, abs=0.02)


def test_gusts_that_the_airspeed_shows_are_no_bias_of_it():
    # Heavy aircraft: gusts change airspeed and heading, and hardly the velocity over ground.
    random, filter_, gust = np.random.default_rng(3), AirFilter(), np.zeros(3)
    position = np.array([100.0, 50.0, 120.0])
    for k in range(round(150.0 / STEP)):
        psi = TURN * k * STEP
        ground = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        gust += -STEP / 12.0 * gust + np.sqrt(STEP) * random.standard_normal(3)
        filter_.see(k * STEP, position, ground, ground - gust)
        position = position + STEP * ground
    assert abs(filter_.state.alpha[0]) < 0.1
    assert abs(filter_.state.beta[0]) < 0.1


def test_noise_of_the_ground_velocity_is_smoothed_and_its_size_seen():
    filter_, position = flown(100.0, noise=0.3)
    np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, [3.0, -5.0, 0.2], atol=0.2)
    assert (
        np.linalg.norm(filter_.found.vehicle[:3] - position) < 1.2
    )  # of the newest, a step before


def test_gusts_last_as_long_as_drydens():
    filter_, _ = flown(1.0)
    long, also_long, short = filter_.found.times
    assert long == also_long == pytest.approx(275.0 / SPEED, rel=0.01)
    assert short == pytest.approx(120.0 / SPEED, rel=0.01)


def test_after_a_gap_the_position_begins_anew_and_the_wind_is_kept():
    filter_, _ = flown(60.0)
    filter_.see(70.0, np.array([5e3, 0.0, 100.0]), np.array([25.0, -5.0, 0.2]),
                   np.array([22.0, 0.0, 0.0]))  # fmt: skip
    assert filter_.found.vehicle[:3][0] == pytest.approx(5e3, abs=1.0)
    np.testing.assert_allclose(filter_.state.wind, [3.0, -5.0, 0.2], atol=0.2)


def test_what_slips_while_it_rolls_is_taken_for_no_bias():
    """An aircraft that rolls into its turn has its nose off by degrees; nothing is biased."""
    found, wind = AirFilter(), np.array([8.0, 0.0, 0.0])
    position, heading = np.zeros(3), 0.0
    for tick in range(1500):
        time = 0.02 * tick
        turn_rate = 0.3 * math.sin(0.9 * time) if time < 20.0 else 0.08
        slip = 0.1 * math.cos(0.9 * time) if time < 20.0 else 0.0  # with the rate of roll
        heading += 0.02 * turn_rate
        air = 22.0 * np.array([math.cos(heading), math.sin(heading), 0.0])
        seen = 22.0 * np.array([math.cos(heading + slip), math.sin(heading + slip), 0.0])
        position = position + 0.02 * (air + wind)
        found.see(time, position, air + wind, seen)
    assert abs(found.state.alpha[0]) < 0.02
    assert abs(found.state.beta[0]) < 0.02
    np.testing.assert_allclose(found.state.wind + found.state.gust, wind, atol=1.0)


def test_noise_of_the_position_does_not_become_wind():
    def error(told):
        found, _ = flown(3.0, position_noise=(3.0, 3.0, 6.0), noise=0.3, told=told)
        return np.linalg.norm(found.state.wind + found.state.gust - [3.0, -5.0, 0.2])

    assert error(True) < 1.5
    assert error(False) < 1.5


@pytest.mark.parametrize("deviation", [0.5, 2.0, 5.0])
def test_noise_of_the_position_that_nobody_tells_is_found_at_once(deviation):
    """Positions that scatter are no jumps, and lead to no bias of the ground velocity."""
    flight = enumerate(flown_by_steps(30, position_noise=(deviation,) * 3, told=False), 1)
    for found, position in (each for k, each in flight if k * STEP in (3.0, 10.0, 30.0)):
        assert np.linalg.norm(found.found.vehicle[:3] - position) < 1.2 + 2.0 * deviation
        assert np.abs(found.state.bias).max() < 0.5 + 0.4 * deviation
        assert found.health.states[POSITION] == USED


@pytest.mark.parametrize("every", [5, 20])
def test_a_position_that_is_seldom_measured_is_no_fault(every):
    """States come 20 times a second, with the newest position of a receiver that has 4 or 1."""
    found, random, read = AirFilter(), np.random.default_rng(4), np.zeros(3)
    for tick in range(1200):
        psi = TURN * tick * STEP
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        if tick % every == 0:
            place = SPEED / TURN * np.array([np.sin(psi), -np.cos(psi), 0.0])
            read = place + 0.5 * random.standard_normal(3)
        found.see(tick * STEP, read, air, air)
        assert found.health.states[POSITION] == USED


def test_each_axis_is_smoothed_by_its_own_noise():
    def spread(told):
        flight = enumerate(flown_by_steps(56, position_noise=(1.0, 1.0, 9.0), told=told), 1)
        every = round(4.0 / STEP)
        errors = [
            found.found.vehicle[:3] - position
            for k, (found, position) in flight
            if k >= 5 * every and k % every == 0
        ]
        return np.sqrt(np.mean(np.square(errors), axis=0))

    (east, north, up), (_, _, up_untold) = spread(True), spread(False)
    assert up < 0.95 * up_untold
    assert up_untold < 1.5  # soon found from the scatter
    assert max(east, north) < 1.3  # of which 1.1 m are the step that the truth is ahead


@pytest.mark.parametrize("climb", [0.03, -0.5])
def test_positions_in_whole_metres_are_followed(climb):
    """Most heights repeat the one before: whoever waits for another goes by the velocity alone."""
    known = {"wind": (3.0, -5.0, climb), "bias": (0.0, 0.0, 0.2), "noise": 0.1}
    found, position = flown(120.0, resolution=1.0, **known)
    assert np.abs(found.found.vehicle[2] - position[2]) < 1.0
    assert found.health.states["position"] == "used"


@pytest.mark.parametrize("gap", [0.0, 1.0])
def test_a_velocity_of_the_wrong_sign_is_not_the_wind(gap):
    """Positions say that it was not flown, however long it lasts and whatever went before."""
    filter_, position = AirFilter(), np.array([100.0, 50.0, 120.0])
    wind, begin = np.array([3.0, -5.0, 0.0]), 30.0
    for k in range(round(60.0 / STEP)):
        time, psi = k * STEP, TURN * k * STEP
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        wrong = begin <= time < begin + 8.0
        ground = (-1.0 if wrong else 1.0) * (air + wind)
        if not begin - gap <= time < begin:
            filter_.see(time, position, ground, air)
            if time > 10.0:
                np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, wind, atol=0.3)
                np.testing.assert_allclose(filter_.found.vehicle[:3], position, atol=0.3)
        middle = psi + 0.5 * TURN * STEP
        position = position + STEP * SPEED * np.array([np.cos(middle), np.sin(middle), 0.0])
        position = position + STEP * wind


def test_a_wind_that_turns_at_once_is_believed_after_a_second():
    filter_, position = AirFilter(), np.array([100.0, 50.0, 120.0])
    before, after = np.array([10.0, 0.0, 0.0]), np.array([-10.0, 0.0, 0.0])
    for k in range(round(40.0 / STEP)):
        time, psi = k * STEP, TURN * k * STEP
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        wind = before if time < 30.0 else after
        filter_.see(time, position, air + wind, air)
        position = position + STEP * (air + wind)
        if time > 33.0:
            np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, after, atol=0.5)


def covariance(lane):
    """Of a filter's state, from its upper triangle by columns."""
    upper = np.zeros((SIZE, SIZE))
    upper.T[np.tril_indices(SIZE)] = lane.triangle
    np.testing.assert_array_equal(np.diag(upper), lane.triangle[DIAGONAL])
    return upper + np.triu(upper, 1).T


def normalised_errors(seed, noise, walk):
    """Squared errors of position and of wind with gust, over their covariances, as it circles."""
    random, filter_ = np.random.default_rng(seed), AirFilter()
    position, wind = np.array([0.0, 0.0, 120.0]), np.array([5.0, -3.0, 0.0])
    times = np.array([275.0, 275.0, 120.0]) / SPEED
    spread, decay, rows = np.sqrt(0.5 * walk * times), np.exp(-STEP / times), []
    gust = spread * random.standard_normal(3)
    seen = np.zeros((2, 3, SIZE))
    seen[0][:, P] = seen[1][:, W] = seen[1][:, G] = np.eye(3)
    for k in range(round(80.0 / STEP)):
        psi = TURN * k * STEP
        air = SPEED * np.array([np.cos(psi), np.sin(psi), 0.0])
        blown = [position, air + wind + gust]
        place, ground = (
            each + size * random.standard_normal(3) for each, size in zip(blown, noise, strict=True)
        )
        filter_.see(k * STEP, place, ground, air, *[(size,) * 3 for size in noise])
        if k * STEP > 30.0 and k % 20 == 0:
            known = filter_._known.main
            errors = known.state[P] - position, known.state[W] + known.state[G] - wind - gust
            rows.append(
                [
                    error @ np.linalg.solve(part @ covariance(known) @ part.T, error)
                    for part, error in zip(seen, errors, strict=True)
                ]
            )
        middle = psi + 0.5 * TURN * STEP
        position = position + STEP * SPEED * np.array([np.cos(middle), np.sin(middle), 0.0])
        position = position + STEP * (wind + gust)
        gust = decay * gust + spread * np.sqrt(1.0 - decay**2) * random.standard_normal(3)
    return np.array(rows)


@pytest.mark.parametrize(("noise", "walk"), [((1.0, 0.3), 1.0), ((0.3, 0.1), 0.25)])
def test_errors_are_as_large_as_the_filter_says(noise, walk):
    """NEES, mean over flights: 3 of a filter that knows all; this one may only be pessimistic."""
    place, air = np.concatenate([normalised_errors(seed, noise, walk) for seed in range(3)]).mean(0)
    assert 1.5 < place < 3.5
    assert 0.75 < air < 3.5


def test_an_airspeed_that_is_far_off_is_not_used_even_once():
    """Before it is known what has become of the sensor: the wind tells the airspeed meanwhile."""
    filter_, position = flown(120.0)
    time, psi = 120.0, TURN * 120.0
    ahead = np.array([np.cos(psi), np.sin(psi), 0.0])
    filter_.see(time, position, SPEED * ahead + [3.0, -5.0, 0.2], 5.0 * ahead)
    assert filter_.found.vehicle[5] == pytest.approx(SPEED, abs=0.2)
    assert filter_.health.states["airspeed"] == "jumped"
    np.testing.assert_allclose(filter_.state.wind + filter_.state.gust, [3.0, -5.0, 0.2], atol=0.2)


def test_a_wind_without_heading_is_as_sure_as_it_says_after_a_straight_flight():
    """Along a line the airspeed tells half of the wind only; the rest must not be made up."""
    wind, apart = np.array([0.0, 8.0, 0.0]), []
    for seed in range(12):
        random, filter_, gust = np.random.default_rng(seed), AirFilter(), np.zeros(3)
        psi, position = random.uniform(-3.0, 3.0), np.array([0.0, 0.0, 120.0])
        for k in range(round(40.0 / STEP)):
            turn = 0.0 if k * STEP < 8.0 else TURN
            air = 26.0 * np.array([np.cos(psi), np.sin(psi), 0.0])
            filter_.see(k * STEP, position, air + wind + gust, air)
            arc = 0.5 * STEP * turn * np.array([-air[1], air[0], 0.0])
            position = position + STEP * (air + wind + gust + arc)
            psi += STEP * turn
            gust += -STEP / 10.0 * gust + 0.4 * np.sqrt(STEP) * random.standard_normal(3)
            lane = filter_._known.no_heading
            deviation = math.sqrt(lane.triangle[DIAGONAL[W]][:2].max())
            if deviation <= WIND_KNOWN:
                error = np.linalg.norm((lane.state[W] - wind)[:2])
                apart.append(error / max(deviation, 1.0))
    assert max(apart) < 6.0


def test_a_plan_counts_on_gusts_that_last_and_not_on_what_shakes():
    """Unless it is the heading that shakes: the gust is then what it errs by."""
    random, counted, steady = np.random.default_rng(1), [], np.array([22.0, 0.0, 0.0])
    memory, inputs = QUICK.symbol("memory")
    elapsed, gust, air, usual = [ca.SX.sym(name, size) for name, size in SIZES.items()]
    lane = SimpleNamespace(air=air, steady=usual)
    step = [elapsed, gust, air, usual]
    after, lasting = lasting_gust(inputs, elapsed, gust, lane)
    step = ca.Function("step", [memory, *step], [QUICK.joined(after), lasting])
    for kind in ("gust", "swing", "turbulence", "heading"):
        known, gust = np.zeros(QUICK.size), np.zeros(3)
        quick, kept = [], []
        for k in range(round(60.0 / STEP)):
            shock = np.sqrt(STEP) * random.standard_normal(3)
            if kind == "gust":
                gust = gust - STEP / 10.0 * gust + shock
            elif kind == "turbulence":
                gust = gust - STEP / 0.3 * gust + 3.0 * shock
            else:
                gust = np.full(3, math.sin(2.0 * math.pi * 0.8 * k * STEP))
            air = steady - gust if kind == "heading" else steady
            found = step(known, STEP, gust, air, steady)
            known, lasts = (np.array(value).ravel() for value in found)
            slow = QUICK.parts(known).slow
            quick.append(gust - slow)
            kept.append(lasts - slow)
        late = slice(round(30.0 / STEP), None)
        counted.append(np.std(kept[late]) / np.std(quick[late]))
    assert counted[0] > 0.9
    assert counted[1] == counted[2] == 0.0
    assert counted[3] == pytest.approx(1.0)


def test_without_an_airspeed_the_path_angle_is_what_is_measured():
    """Not that over ground, which the wind changes."""
    air = AirEstimate()
    measurement = Measurement(
        0.0, np.zeros(3), np.array([30.0, 0.0, 4.0]), 0.0, 0.18, 0.0, axis=Axis.AIR_VELOCITY
    )
    found = air.update(measurement, measurement.state(30.0), np.zeros(3), 0.0, True)
    assert found.vehicle[4] == pytest.approx(0.18)
