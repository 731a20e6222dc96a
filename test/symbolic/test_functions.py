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

"""CasADi functions: one thread builds at a time, own arrays, time steps and linearisation."""

import threading
import time

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import (
    error_dynamics,
    relative_state,
    steady_inputs,
    vehicle_state,
)
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.symbolic.functions import BufferedFunction, linearise, one_at_a_time


def test_one_thread_waits_for_the_other():
    inside, most = [], []

    @one_at_a_time
    def work(name):
        inside.append(name)
        most.append(len(inside))
        time.sleep(0.01)
        inside.remove(name)
        return name

    threads = [threading.Thread(target=work, args=(name,)) for name in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] * 6
    assert work("again") == "again"


def test_work_may_call_other_work():
    inner = one_at_a_time(lambda value: value + 1)
    assert one_at_a_time(lambda value: 2 * inner(value))(3) == 8


x, y = ca.SX.sym("x", 2, 3), ca.SX.sym("y")
PRODUCT = ca.Function("product", [x, y], [ca.densify(x.T * y), ca.sin(y)])


def test_arguments_are_read_and_results_are_written_by_columns():
    buffered = BufferedFunction(PRODUCT)
    values = np.arange(6.0).reshape(2, 3)
    buffered.arguments[0][:], buffered.arguments[1][0] = values.ravel(order="F"), 2.0
    buffered.evaluate()
    whole, sine = (np.array(result) for result in PRODUCT(values, 2.0))
    np.testing.assert_array_equal(buffered.results[0], whole.ravel(order="F"))
    np.testing.assert_array_equal(buffered.results[1], sine.ravel())


def test_a_given_array_is_read_as_it_is_when_evaluated():
    given = np.zeros((3, 2))  # of the transposed shape: the same numbers in the same order
    buffered = BufferedFunction(PRODUCT, [given])
    buffered.arguments[1][0] = 1.0
    given[:] = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    buffered.evaluate()
    np.testing.assert_array_equal(buffered.results[0].reshape(2, 3), given.T)


B = np.vstack([np.zeros(3), [1, 0, 0], np.zeros(3), [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize("scheme", ["euler", "rk4"])
@pytest.mark.parametrize("model", RELATIVE_MODEL.names)
@pytest.mark.parametrize("direction", ["clockwise", "counter_clockwise"])
def test_origin_is_an_equilibrium(model, scheme, direction):
    dynamics = error_dynamics(model, Orbit(150.0, 50.0, 4.0, direction), 1.0, scheme)
    np.testing.assert_allclose(np.array(dynamics(0, 0)), 0.0, atol=1e-14)


def test_linearisation_of_the_exact_model(orbit):
    """Closed forms of the Jacobian at the reference, Euler, T_s = 1."""
    a, b = linearise(error_dynamics("exact", orbit, 1.0))
    r, z, v, d = 150.0, 50.0, 4.0, np.sqrt(150.0**2 - 50.0**2)
    expected = np.eye(5)
    expected[0, 1], expected[0, 3] = v * d / r, v * z / r
    expected[1, 0], expected[1, 2], expected[1, 4] = -v * r / d**3, v * z / d**3, 1 / d
    expected[2, 3] = v
    np.testing.assert_allclose(a, expected, atol=1e-14)
    np.testing.assert_allclose(b, B, atol=1e-14)
    assert a[0, 1] == pytest.approx(3.77124, abs=5e-6)
    assert a[1, 0] == pytest.approx(-2.12132e-4, abs=5e-10)


def test_linearisation_of_the_paper_model(orbit):
    """Jacobian of (11): the printed A[0,3] = 4 and A[1,3] are zero in truth."""
    a, _ = linearise(error_dynamics("paper", orbit, 1.0))
    expected = np.eye(5)
    expected[0, 1], expected[2, 3] = 4.0, 4.0
    expected[1, 0], expected[1, 4] = -4.0 / 150.0**2, 1 / 150.0
    np.testing.assert_allclose(a, expected, atol=1e-14)


def test_linearisation_away_from_the_origin_is_the_difference_quotient(orbit):
    dynamics = error_dynamics("exact", orbit, 1.0, "rk4")
    x, u, h = np.array([10.0, 0.2, -5.0, 0.1, 0.5]), np.array([0.05, 0.02, 0.1]), 1e-6
    a, b = linearise(dynamics, x, u)
    for matrix, at in ((a, 0), (b, 1)):
        for column in range(matrix.shape[1]):
            step = np.zeros(matrix.shape[1])
            step[column] = h
            up, down = (
                np.array(dynamics(*((x + s, u) if at == 0 else (x, u + s)))).ravel()
                for s in (step, -step)
            )
            np.testing.assert_allclose(matrix[:, column], (up - down) / (2 * h), atol=1e-7)


@pytest.mark.parametrize(("scheme", "order"), [("euler", 1), ("rk4", 4)])
def test_schemes_have_their_order(orbit, scheme, order):
    """Halving the step divides the error of one step by 2^(order + 1)."""
    start = np.array([200.0, 0.6, 40.0, 0.1, 5.0])
    inputs = np.array([0.2, 0.05, 0.3])
    errors = []
    for step in (0.4, 0.2):
        vehicle = advance(vehicle_state(start, 0.3, np.zeros(3)), inputs, step)
        dynamics = error_dynamics("exact", orbit, step, scheme)
        u_ss = steady_inputs("exact", orbit)
        reached = np.array(dynamics(start - orbit.steady_state, inputs - u_ss)).ravel()
        truth = relative_state(vehicle, np.zeros(3)) - orbit.steady_state
        errors.append(np.linalg.norm(reached - truth))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order + 1, abs=0.4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("exact", 1.0, "heun"), "scheme is 'heun'"),
        (("exact", 0.0, "euler"), "step is 0.0"),
        (("flat", 1.0, "euler"), "model is 'flat'"),
    ],
)
def test_bad_arguments_are_named(orbit, arguments, message):
    model, step, scheme = arguments
    with pytest.raises(ValueError, match=message):
        error_dynamics(model, orbit, step, scheme)
