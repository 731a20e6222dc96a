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

"""White noise and wander of signals whose statistics are known."""

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.estimation.noise_meter import NoiseMeters

STEP, COUNT = 0.05, 4000


class NoiseMeter:
    """The meters of one signal, evaluated."""

    def __init__(self, deviation, memory, walk=0.0, size=1):
        self.meters = NoiseMeters([size], [deviation], [walk], memory)
        known, parts = self.meters.layout.symbol("known")
        symbols = [ca.SX.sym(name, count) for name, count in (("dt", 1), ("x", size), ("told", 1))]
        metered = self.meters.metered(parts, *symbols)
        results = [self.meters.layout.joined(metered), metered.held]
        self.update = ca.Function("update", [known, *symbols], results)
        self.walks = ca.Function("walks", [known], [self.meters.walks(parts)])
        self.reset()

    def reset(self):
        layout, self.time = self.meters.layout, -np.inf
        self.known, self.variance = layout.begin, layout.parts(layout.begin).held[0]

    def see(self, time, signal, told=0.0):
        elapsed, self.time = min(time - self.time, 1e3), time
        known, variance = self.update(self.known, elapsed, signal, told)
        self.known, self.variance = np.array(known).ravel(), float(variance)

    @property
    def walk(self):
        return float(self.walks(self.known))

    @property
    def deviation(self):
        return np.sqrt(self.variance)


def met(signal, **prior):
    meter = NoiseMeter(0.1, 100.0, **prior, size=np.size(signal[0]))
    for k, value in enumerate(signal):
        meter.see(k * STEP, np.atleast_1d(value))
    return meter


@pytest.mark.parametrize(("noise", "walk"), [(0.3, 0.0), (0.0, 0.8), (0.3, 0.8), (0.05, 0.1)])
def test_both_are_told_apart(noise, walk):
    random = np.random.default_rng(1)
    wandering = np.cumsum(np.sqrt(walk * STEP) * random.standard_normal((COUNT, 2)), axis=0)
    meter = met(wandering + noise * random.standard_normal((COUNT, 2)), walk=1.0)
    assert meter.deviation == pytest.approx(noise, rel=0.1, abs=0.25 * np.sqrt(walk * STEP))
    assert meter.walk == pytest.approx(walk, rel=0.25, abs=0.15 * noise**2 + 0.02)


def test_what_stands_still_has_neither():
    meter = met(np.full(COUNT, 7.0), walk=1.0)
    assert meter.deviation < 1e-2
    assert meter.walk < 0.02


def test_a_gap_is_no_change():
    meter = NoiseMeter(0.1, 100.0)
    for k in range(COUNT):
        meter.see(k * STEP + 50.0 * (k >= COUNT // 2), np.array([0.0 if k < COUNT // 2 else 1e6]))
    assert meter.deviation < 1e-2


def test_before_anything_is_seen_the_prior_holds_and_reset_brings_it_back():
    meter = NoiseMeter(0.2, 10.0, 1.5)
    for _ in range(2):
        assert meter.deviation == pytest.approx(0.2)
        assert meter.walk == pytest.approx(1.5)
        for k in range(50):
            meter.see(k * STEP, np.array([3.0 * (-1.0) ** k]))
        assert meter.deviation > 1.0
        meter.reset()


def white(deviations, told, seed=4):
    """Variances after each sample of white noise whose source tells a variance with each."""
    random, meter, variances = np.random.default_rng(seed), NoiseMeter(0.1, 40.0, size=3), []
    for k, (deviation, variance) in enumerate(zip(deviations, told, strict=True)):
        meter.see(k * STEP, deviation * random.standard_normal(3), variance)
        variances.append(meter.variance)
    return np.array(variances)


def test_what_is_told_counts_until_the_noise_is_measured():
    variances = white([3.0] * COUNT, [9.0] * COUNT)
    np.testing.assert_array_equal(variances[:20], 9.0)  # nothing is told: 0.01 of the prior
    np.testing.assert_allclose(variances[100:], 9.0, rtol=0.5)


def test_what_is_told_wrong_does_not_last():
    untold = white([3.0] * COUNT, [0.0] * COUNT)
    for lie in (1e-8, 1e-2, 1e2, 1e4):
        variances = white([3.0] * COUNT, [9.0 * lie] * COUNT)
        np.testing.assert_allclose(variances[60:], untold[60:], rtol=1e-9, err_msg=f"{lie}")


def test_a_change_that_is_told_counts_at_once():
    half = COUNT // 2
    deviations = np.repeat([0.3, 3.0], half)
    variances = white(deviations, deviations**2)
    np.testing.assert_allclose(variances[100:], deviations[100:] ** 2, rtol=0.4)
    wrong_by_4 = white(deviations, 4.0 * deviations**2)
    np.testing.assert_allclose(wrong_by_4[100:], variances[100:], rtol=1e-6)


def test_what_was_told_last_holds_while_nothing_is_told():
    variances = white([3.0] * 40, [9.0, 0.0] * 20)
    np.testing.assert_array_equal(variances, 9.0)
