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

"""The checker's arithmetic encloses what it must."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.terminal.interval import Interval

numbers = st.floats(-1e3, 1e3, allow_nan=False)


def inside(value, interval):
    return bool(interval.lower <= value <= interval.upper)


@given(numbers, numbers)
def test_sums_and_products_hold_the_exact_value(a, b):
    x, y = Fraction(a), Fraction(b)
    for exact, interval in (
        (x + y, Interval(a) + Interval(b)),
        (x - y, Interval(a) - Interval(b)),
        (x * y, Interval(a) * Interval(b)),
        (x * x, Interval(a).square()),
    ):
        assert Fraction(float(interval.lower)) <= exact <= Fraction(float(interval.upper))


@given(numbers, st.floats(0.0, 7.0), st.floats(0.0, 1.0))
def test_waves_hold_samples(a, width, share):
    x = Interval(a, a + width)
    t = a + share * width
    assert inside(math.sin(t), x.sin())
    assert inside(math.cos(t), x.cos())


def test_sine_of_a_hump_is_its_range():
    hump = Interval(0.1, 3.0).sin()
    assert hump.upper == 1.0
    assert hump.lower == pytest.approx(math.sin(0.1), abs=1e-12)


def test_division_by_zero_and_negative_root_prove_nothing():
    for bad in (Interval(1.0) / Interval(-1.0, 1.0), Interval(-1.0, 4.0).sqrt()):
        assert not bool(bad.lower > -np.inf)


@given(numbers, st.floats(0.0, 10.0), st.floats(0.0, 1.0))
def test_square_holds_samples(a, width, share):
    assert inside(
        (a + share * width) ** 2 * (1 + 0.0), Interval(a - 1e-9, a + width + 1e-9).square()
    )
