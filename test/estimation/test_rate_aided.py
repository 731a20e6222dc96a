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

"""A quantity from itself and its biased rate."""

import math

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.estimation.rate_aided import RATE_AIDED, RATE_BIAS, begin_values, smoothed

STEP = 0.05


class Heading:
    """The filter of the heading, evaluated; the other quantities stand still.

    Args:
        biased: Whether the rate may have a bias.
    """

    def __init__(self, biased=True):
        known, parts = RATE_AIDED.symbol("known")
        symbols = ca.SX.sym("dt"), *[ca.SX.sym(name, 3) for name in ("x", "rate", "told")]
        after = RATE_AIDED.joined(smoothed(parts, *symbols, ca.DM(3 * [biased])))
        self._update = ca.Function("update", [known, *symbols], [after])
        self._known, self._begun = RATE_AIDED.begin.copy(), False

    @property
    def parts(self):
        return RATE_AIDED.parts(self._known)

    def update(self, elapsed, measured, rate, told):
        seen = [np.array([value, 0.0, 0.0]) for value in (measured, rate, told)]
        if not self._begun:
            begin_values(self.parts, *seen)
            self._begun, elapsed = True, 0.0
        self._known = np.array(self._update(self._known, elapsed, *seen)).ravel()


def _as_of(aided, other):
    aided._known, aided._begun = other._known.copy(), True
    return aided


def filtered(count=2000, noise=0.0, bias=0.0, seed=0, told=0.0):
    """Filter after a course of turns, the errors of its values and the truth at its end."""
    random, errors = np.random.default_rng(seed), []
    aided = Heading()
    for k in range(count):
        time = k * STEP
        truth, rate = 3.0 * np.sin(0.2 * time) + 0.1 * time, 0.6 * np.cos(0.2 * time) + 0.1
        measured = np.angle(np.exp(1j * (truth + noise * random.standard_normal())))
        aided.update(STEP, measured, rate + bias, told)
        errors.append(np.angle(np.exp(1j * (aided.parts.value[0] - truth))))
    return aided, np.array(errors)


def test_without_noise_the_measurement_counts():
    _, errors = filtered()
    assert np.abs(errors).max() < 1e-4  # trapezoids of the rate


@pytest.mark.parametrize("bias", [0.035, -0.1])
def test_the_bias_of_the_rate_is_found(bias):
    aided, errors = filtered(bias=bias)
    assert aided.parts.bias[0] == pytest.approx(bias, abs=2e-4)
    assert np.abs(errors[-100:]).max() < 1e-4


def test_a_bias_is_kept_and_can_be_found_after_a_rate_that_has_none():
    """As of a gyro whose turn the bank tells for a while."""
    aided = Heading(biased=False)
    for k in range(1200):
        if k == 200:
            assert aided.parts.bb[0] == RATE_BIAS[0] ** 2
            aided = _as_of(Heading(), aided)
        aided.update(STEP, 0.1 * k * STEP, 0.1 + 0.035 * (k >= 200), 0.0)
    assert aided.parts.bias[0] == pytest.approx(0.035, abs=2e-3)
    still = _as_of(Heading(biased=False), aided)
    still.update(STEP, 0.1 * 1200 * STEP, 0.1, 0.0)
    assert still.parts.bias[0] == aided.parts.bias[0]


def test_a_rate_that_nobody_tells_is_found_from_the_angle():
    aided = Heading()
    for k in range(400):
        aided.update(STEP, math.remainder(0.2 * max(k * STEP - 5.0, 0.0), math.tau), 0.0, 0.0)
    assert -aided.parts.bias[0] == pytest.approx(0.2, abs=1e-3)


def test_noise_is_smoothed_by_the_rate_though_nobody_tells_how_much_there_is():
    aided, errors = filtered(count=4000, noise=0.02, bias=0.035)
    assert np.sqrt(np.mean(errors[2000:] ** 2)) < 0.2 * 0.02
    assert aided.parts.bias[0] == pytest.approx(0.035, abs=2e-3)


def test_a_rate_that_lags_at_first_has_no_bias_where_it_can_have_none():
    """As of a path that bends while its filter begins: half a second would tell of 0.1 rad/s."""
    found = {}
    for biased in (True, False):
        aided = Heading(biased)
        for k in range(100):
            time = k * STEP
            angle, rate = -0.1 * min(2.0 * time, 1.0), -0.2 * (0.25 < time < 0.5) + 1e-6
            aided.update(STEP, angle, rate, 0.0)
        found[biased] = abs(aided.parts.value[0] - angle), abs(aided.parts.bias[0])
    assert found[False] == pytest.approx((0.0, 0.0), abs=1e-4)
    assert found[True][1] > 0.02


def test_what_begins_anew_is_where_it_is_measured_and_keeps_the_bias():
    aided, _ = filtered(bias=0.035)
    begin_values(aided.parts, *np.array([[0.5, 0.0, 20.0], np.zeros(3), np.zeros(3)]))
    assert aided.parts.value[0] == 0.5
    assert aided.parts.bias[0] == pytest.approx(0.035, abs=2e-4)


def test_noise_that_is_told_is_smoothed_from_the_start():
    def early(told):
        return np.array([filtered(10, 0.05, seed=seed, told=told)[1] for seed in range(40)])

    untold, told = (np.sqrt(np.mean(early(noise)[:, 5:] ** 2)) for noise in (0.0, 0.05))
    assert told < 0.75 * untold
