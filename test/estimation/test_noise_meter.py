"""White noise and wander of signals whose statistics are known."""

import numpy as np
import pytest

from uav_tracking_mpc.estimation.noise_meter import NoiseMeter

STEP, COUNT = 0.05, 4000


def met(signal, **prior):
    meter = NoiseMeter(0.1, 100.0, **prior)
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
        assert meter.walk == 1.5
        for k in range(50):
            meter.see(k * STEP, np.array([3.0 * (-1.0) ** k]))
        assert meter.deviation > 1.0
        meter.reset()
