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

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.dynamics.relative import rates_function
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL
from uav_tracking_mpc.symbolic import functions
from uav_tracking_mpc.terminal.interval import Interval, definite, evaluate

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


@pytest.mark.parametrize("model", RELATIVE_MODEL.names)
def test_rates_over_a_box_hold_what_arb_says_at_its_points(model):
    """An arithmetic of others, with 96 bits, on the same instructions."""
    flint = pytest.importorskip("flint")
    arb, function = flint.arb, rates_function(model)
    known = {
        ca.OP_NEG: lambda a: -a, ca.OP_SQ: lambda a: a * a, ca.OP_TWICE: lambda a: a + a,
        ca.OP_INV: lambda a: 1 / a, ca.OP_SQRT: arb.sqrt, ca.OP_SIN: arb.sin, ca.OP_COS: arb.cos,
        ca.OP_ADD: lambda a, b: a + b, ca.OP_SUB: lambda a, b: a - b,
        ca.OP_MUL: lambda a, b: a * b, ca.OP_DIV: lambda a, b: a / b,
    }  # fmt: skip
    generator = np.random.default_rng(0)
    center = np.array([150.0, 1.5, 50.0, 0.1, 4.0])
    half = np.array([5.0, 0.3, 5.0, 0.3, 0.5])
    still = Interval(np.zeros(3))
    (rates,) = evaluate(function, [Interval(center - half, center + half), still])
    for _ in range(50):
        x = center + half * generator.uniform(-1.0, 1.0, 5)
        (points,) = evaluate(function, [Interval(x), still])
        with flint.ctx.workprec(96):
            balls = [[arb(float(value)) for value in x], [arb(0)] * 3]
            (exact,) = functions.evaluate(
                function, balls, arb, lambda code, *operands: known[code](*operands)
            )
        for interval in (rates, points):
            for lower, ball, upper in zip(interval.lower, exact, interval.upper, strict=True):
                assert arb(float(lower)) <= ball <= arb(float(upper))


def test_unknown_operation_is_refused():
    x = ca.SX.sym("x")
    with pytest.raises(ValueError, match="not known"):
        evaluate(ca.Function("f", [x], [ca.erf(x)]), [Interval([0.0])])


@pytest.mark.parametrize(
    ("lower", "upper", "whole"),
    [
        (np.diag([1.0, 2.0]), None, True),
        (np.diag([1.0, -2.0]), None, False),
        (np.ones((2, 2)), None, False),
        ([[1.0, -1.5], [-1.5, 1.0]], [[1.0, 1.5], [1.5, 1.0]], False),
    ],
)
def test_definiteness(lower, upper, whole):
    assert definite(Interval(lower, upper)) == whole


def test_entries_of_functions_stand_where_they_belong():
    """Also zeros that the function does not compute, on many boxes at once."""
    x = ca.SX.sym("x", 2)
    function = ca.Function("f", [x], [ca.vertcat(x[1], 3.0), ca.jacobian(x * x[1], x)])
    for found, expected in zip(
        evaluate(function, [Interval([[1.0, 2.0], [5.0, 4.0]])]),
        ([[2.0, 3.0], [4.0, 3.0]], [[[2.0, 1.0], [0.0, 4.0]], [[4.0, 5.0], [0.0, 8.0]]]),
        strict=True,
    ):
        np.testing.assert_allclose(found.middle(), expected, rtol=1e-15)
