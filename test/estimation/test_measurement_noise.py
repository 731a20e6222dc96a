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

import numpy as np
import pytest

from uav_tracking_mpc.estimation.target_filter import (
    MANOEUVRE_TIME,
    QUANTILE,
    RATIO_MAX,
    MeasurementNoise,
    _quantile,
)


def seen(times, positions, told=0.1):
    noise = MeasurementNoise()
    for time, position in zip(times, positions, strict=True):
        noise.see(time, np.asarray(position, dtype=float), np.full(3, told**2))
    return noise


def scattered(times, sigma, seed=0):
    run = np.outer(times, [5.0, -3.0, 0.5])
    return run + sigma * np.random.default_rng(seed).standard_normal(run.shape)


@pytest.mark.parametrize("sigma", [0.02, 0.5, 5.0])
def test_the_noise_of_a_run_is_found(sigma):
    """By the median of sixty squares it is known to a tenth or so."""
    random = np.random.default_rng(2)
    found = []
    for seed in range(10):
        times = np.cumsum(random.uniform(0.05, 0.4, 100))  # irregular
        found.append(0.1 * np.sqrt(seen(times, scattered(times, sigma, seed)).scales[0]))
    assert np.mean(found) == pytest.approx(sigma, rel=0.08)
    assert np.std(found) < 0.15 * sigma


def test_noise_told_far_too_small_is_found_in_a_second():
    times = 0.2 * np.arange(6)
    found = [
        0.1 * np.sqrt(seen(times, scattered(times, 5.0, seed)).scales[0]) for seed in range(20)
    ]
    assert min(found) > 1.0
    assert np.median(found) == pytest.approx(5.0, rel=0.4)


def test_before_anything_is_measured_what_is_told_counts():
    times = 0.2 * np.arange(2)
    noise = seen(times, scattered(times, 5.0))
    assert (noise.scales == 1.0).all() and not noise.known


def test_turns_jumps_and_outliers_are_no_noise():
    times = 0.1 * np.arange(200)
    positions = scattered(times, 0.2)
    positions[60:, :2] = positions[60:, :2] @ [[0.0, 1.0], [-1.0, 0.0]]  # a turn and a jump
    positions[100:] += 300.0
    positions[::10] += np.random.default_rng(3).uniform(50.0, 500.0, (20, 3))
    assert 0.1 * np.sqrt(seen(times, positions).scales[0]) == pytest.approx(0.2, rel=0.5)


def test_a_circle_hardly_counts_as_noise():
    times = 0.2 * np.arange(100)
    angle = 0.05 * times
    circle = 100.0 * np.array([np.cos(angle), np.sin(angle), 0.0 * angle]).T
    assert 0.1 * np.sqrt(seen(times, circle).scales[0]) < 0.01


def test_variances_that_differ_are_weighed():
    """Told rightly that each other position is ten times as noisy, nothing is to be corrected."""
    random, noise = np.random.default_rng(5), MeasurementNoise()
    for k in range(60):
        sigma = 2.0 if k % 2 else 0.2
        noise.see(0.2 * k, sigma * random.standard_normal(3), np.full(3, sigma**2))
    assert noise.scales[0] == pytest.approx(1.0, rel=0.4)


@pytest.mark.parametrize("sigma", [[0.2, 0.2, 4.0], [5.0, 0.3, 0.3], [1e-3, 1e-3, 1.0]])
def test_axes_that_differ_much_have_factors_of_their_own(sigma):
    times = 0.2 * np.arange(240)
    found = 0.1 * np.sqrt(seen(times, scattered(times, np.array(sigma))).scales)
    assert found == pytest.approx(sigma, rel=0.25, abs=2e-3)


@pytest.mark.parametrize("least", [1e-153, 1e-100, 1e-9])
def test_noise_that_is_hardly_any_leaves_the_factors_finite(least):
    """And what is then noise is not divided by it."""
    noise, random = MeasurementNoise(), np.random.default_rng(0)
    for k in range(600):
        place = (1e6 if k > 200 else least) * random.standard_normal()
        noise.see(0.1 * k, np.array([place, 0.0, 0.0]), np.full(3, 1e-6))
        assert np.isfinite(noise.scales).all()
        assert (noise.scales > 0.0).all()


@pytest.mark.parametrize("gap", [MANOEUVRE_TIME + 1.0, 1e-3 * 0.1 / RATIO_MAX, 1e-300])
def test_what_says_nothing_of_noise_is_left_out(gap):
    noise = MeasurementNoise()
    for time in (0.0, gap, gap + 0.1):
        noise.see(time, np.array([1e6 * time, 0.0, 0.0]) ** 2, np.full(3, 0.01))
    assert (noise.scales == 1.0).all()


@pytest.mark.parametrize("count", [1, 2, 3, 24, 239, 240])
def test_the_quantile_is_that_of_numpy(count):
    values = np.random.default_rng(count).exponential(size=count)
    expected = np.quantile(values, QUANTILE)
    assert _quantile(values) == expected
