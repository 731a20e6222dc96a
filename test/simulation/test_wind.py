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

"""The wind against the closed forms of MIL-F-8785C."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import welch

from uav_tracking_mpc.dynamics.air import FOOT, gust_scales
from uav_tracking_mpc.simulation.wind import GUST_STEP, ExactStep, GustFilter, Wind

HEIGHT, AIRSPEED, INTENSITY = 20.0, 100.0, 10.0


def seed(number=0):
    return np.random.SeedSequence(number)


def blowing(number=0, heading=0.0):
    return Wind((0.0, 0.0, 0.0), INTENSITY, seed(number), heading, HEIGHT)


def gusts(count, number=0, airspeed=AIRSPEED):
    """Gusts along the axes of ``map``, which are theirs at heading 0, shape (count, 3)."""
    wind = blowing(number)
    samples = np.empty((count, 3))
    for sample in samples:
        sample[:] = wind.velocity
        wind.advance(GUST_STEP, airspeed, HEIGHT, heading=0.0, turn=0.0)
    return samples


@pytest.fixture(scope="module")
def record():
    return gusts(100_000)


def test_scales_at_the_ends_of_the_model():
    """At 1000 ft all lengths are 1000 ft and all strengths equal; below 10 ft nothing changes."""
    top = gust_scales(1000.0 * FOOT, 10.0)
    np.testing.assert_allclose(top, [1.0, 1.0, 1000.0 * FOOT, 1000.0 * FOOT])
    assert gust_scales(5000.0, 10.0) == top
    assert gust_scales(-5.0, 10.0) == gust_scales(10.0 * FOOT, 10.0)
    horizontal, vertical, long, short = gust_scales(100.0 * FOOT, 10.0)
    assert horizontal / vertical == pytest.approx(1.0 / (0.177 + 0.0823) ** 0.4)
    assert long / short == pytest.approx(1.0 / (0.177 + 0.0823) ** 1.2)
    assert short == pytest.approx(100.0 * FOOT)


@given(st.floats(1e-9, 50.0))
def test_noise_is_that_of_the_exact_discretisation(distance):
    """SciPy's matrix exponential and Lyapunov equation; absolute, for the difference cancels."""
    a, b = np.array([[-1.0, 0.0], [1.0, -1.0]]), np.array([[np.sqrt(2.0)], [0.0]])
    stationary = solve_continuous_lyapunov(a, -b @ b.T)
    np.testing.assert_allclose(stationary, [[1.0, 0.5], [0.5, 0.5]])
    transition = expm(a * distance)
    step = ExactStep(distance)
    factor = np.array([[step.p_p, 0.0], [step.p_m, step.m_m]])
    np.testing.assert_allclose(
        factor @ factor.T, stationary - transition @ stationary @ transition.T, atol=1e-14
    )


def test_noise_over_a_short_distance_keeps_its_digits():
    """Leading terms: 2 s, s^2, 2 s^3 / 3, where the difference above has none left."""
    s = 1e-7
    step = ExactStep(s)
    np.testing.assert_allclose(
        [step.p_p**2, step.p_p * step.p_m, step.p_m**2 + step.m_m**2],
        [2 * s, s**2, 2 / 3 * s**3],
        rtol=1e-6,
    )


def test_filter_is_driven_by_its_transition():
    gust = GustFilter(1.0, 0.0)
    gust.step(ExactStep(0.7), 0.0, 0.0)
    assert gust.longitudinal == pytest.approx(np.exp(-0.7))
    k = np.sqrt(0.5)
    p, m = expm(0.7 * np.array([[-1.0, 0.0], [1.0, -1.0]])) @ [1.0, 0.5]
    assert gust.transverse == pytest.approx(k * (np.sqrt(3.0) * p + (1.0 - np.sqrt(3.0)) * m))


def test_variance_is_stationary_from_the_start():
    """Over many seeds, at the first sample and 10 s later."""
    first, later = [], []
    for number in range(1000):
        wind = blowing(number)
        first.append(wind.velocity)
        for _ in range(3):
            wind.advance(GUST_STEP, 5000.0, HEIGHT, heading=0.0, turn=0.0)  # a few lengths
        later.append(wind.velocity)
    horizontal, vertical, _, _ = gust_scales(HEIGHT, INTENSITY)
    for samples in (first, later):
        np.testing.assert_allclose(
            np.std(samples, axis=0), [horizontal, horizontal, vertical], rtol=0.06
        )


def test_gusts_correlate_over_their_lengths(record):
    """exp(-s / L) along, exp(-s / L) (1 - s / 2L) across, over s = V t."""
    horizontal, vertical, long, short = gust_scales(HEIGHT, INTENSITY)
    for axis, (sigma, length) in enumerate(
        [(horizontal, long), (horizontal, long), (vertical, short)]
    ):
        gust = record[:, axis] / sigma
        for lengths in (0.0, 0.5, 1.0, 2.0):
            lag = round(lengths * length / (AIRSPEED * GUST_STEP))
            s = lag * AIRSPEED * GUST_STEP / length
            expected = np.exp(-s) * (1.0 if axis == 0 else 1.0 - s / 2.0)
            measured = np.mean(gust[lag:] * gust[: len(gust) - lag])
            assert measured == pytest.approx(expected, abs=0.07)


def test_spectra_are_drydens(record):
    """One-sided spectra over frequency, Phi(omega / V) 2 pi / V, where holding plays no part."""
    horizontal, vertical, long, short = gust_scales(HEIGHT, INTENSITY)
    frequency, density = welch(record, fs=1.0 / GUST_STEP, nperseg=8192, axis=0)
    for low, high in ((0.1, 0.5), (0.5, 2.0), (2.0, 5.0)):
        band = (frequency >= low) & (frequency < high)
        wave = 2.0 * np.pi * frequency[band] / AIRSPEED
        along = horizontal**2 * 2.0 * long / np.pi / (1.0 + (long * wave) ** 2)
        expected = [along]
        for sigma, length in ((horizontal, long), (vertical, short)):
            x = (length * wave) ** 2
            expected.append(sigma**2 * length / np.pi * (1.0 + 3.0 * x) / (1.0 + x) ** 2)
        for axis in range(3):
            assert np.mean(density[band, axis]) == pytest.approx(
                np.mean(expected[axis]) * 2.0 * np.pi / AIRSPEED, rel=0.12
            )


def test_the_same_seed_blows_the_same_however_the_flight_is_cut():
    def flight(step, number=3):
        wind = Wind((3.0, -2.0, 0.5), INTENSITY, seed(number), heading=0.3, height=HEIGHT)
        moved = np.zeros(3)
        for k in range(round(4.0 / step)):
            moved += wind.advance(step, 20.0, HEIGHT, heading=0.3 + 0.2 * k * step, turn=0.2 * step)
        return moved, wind.velocity

    moved, velocity = flight(0.05)
    for step in (0.01, 0.02, 0.25, 1.0):
        same = flight(step)
        np.testing.assert_allclose(same[0], moved, atol=1e-9)
        np.testing.assert_allclose(same[1], velocity, atol=1e-9)
    assert not np.allclose(flight(0.05, 4)[0], moved)


def test_gusts_turn_with_the_flight():
    """The same numbers: flown North, the gust along the flight blows North."""
    east, north = blowing().velocity, blowing(heading=np.pi / 2).velocity
    np.testing.assert_allclose(north, [-east[1], east[0], east[2]], atol=1e-12)


def test_a_vehicle_that_stands_meets_no_new_gusts():
    """Frozen turbulence: no way through the air, no change."""
    wind = blowing()
    before = wind.velocity
    wind.advance(5.0, 0.0, HEIGHT, heading=0.0, turn=0.0)
    np.testing.assert_array_equal(wind.velocity, before)


def test_another_mean_moves_the_gust_of_now_and_leaves_its_course():
    """The same random numbers are drawn: the gusts go on as they would have."""
    changed, left = (Wind((1.0, 2.0, 0.0), INTENSITY, seed(), 0.3, HEIGHT) for _ in range(2))
    changed.change((4.0, 2.0, -1.0), INTENSITY, 0.3, HEIGHT)
    for _ in range(5):
        np.testing.assert_allclose(changed.velocity - left.velocity, [3.0, 0.0, -1.0], atol=1e-12)
        for wind in (changed, left):
            wind.advance(0.05, AIRSPEED, HEIGHT, heading=0.3, turn=0.0)


def test_the_gust_of_now_grows_with_its_strength():
    wind = blowing(heading=0.3)
    before = wind.velocity
    wind.change((0.0, 0.0, 0.0), 2.0 * INTENSITY, 0.3, HEIGHT)
    np.testing.assert_allclose(wind.velocity, 2.0 * before)
    wind.change((5.0, 0.0, 0.0), 0.0, 0.3, HEIGHT)
    np.testing.assert_array_equal(wind.velocity, [5.0, 0.0, 0.0])
    np.testing.assert_array_equal(wind.advance(2.0, 20.0, HEIGHT, 0.3, 0.0), [10.0, 0.0, 0.0])
