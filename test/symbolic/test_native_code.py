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

"""Machine code computes what CasADi computes, is kept, and is never missed."""

import math
import tempfile
import threading

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.estimation.air_estimate import AirEstimate
from uav_tracking_mpc.symbolic import code_cache, native_code
from uav_tracking_mpc.symbolic.functions import BufferedFunction
from uav_tracking_mpc.symbolic.native_code import MachineCode, NativeFunction

VALUES = [0.0, -0.0, 1.0, -1.0, 0.37, -2.5, 1e300, 1e-310, math.inf, -math.inf, math.nan]
X, Y = ca.SX.sym("x"), ca.SX.sym("y")
EXPRESSIONS = [
    X + Y, X - Y, X * Y, X / Y, -X, X * X, 2.0 * X, 1.0 / X, X**Y, X**3, ca.sqrt(X), ca.fabs(X),
    ca.floor(X), ca.ceil(X), ca.sign(X), ca.copysign(X, Y),
    ca.fmod(X, Y), ca.remainder(X, Y), ca.hypot(X, Y), ca.sin(X), ca.cos(X), ca.tan(X),
    ca.asin(X), ca.acos(X), ca.atan(X), ca.atan2(X, Y), ca.exp(X), ca.log(X), ca.expm1(X),
    ca.log1p(X), X < Y, X <= Y, X == Y, X != Y, ca.logic_and(X, Y), ca.logic_or(X, Y),
    ca.logic_not(X), ca.if_else(X, Y, 2.0), ca.if_else(X > 0.0, Y, X),
]  # fmt: skip
EXTREMES = [ca.fmin(X, Y), ca.fmax(X, Y)]  # which of two zeros that is, is the C library's matter


def bits(array):
    """Whose order nobody may change: all that is no number counts as the same."""
    return np.where(np.isnan(array), math.nan, array).view(np.uint64)


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """A cache of its own, also where it cannot be used, which nothing has been compiled to."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "temp").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temp"))
    native_code._MADE.clear()
    yield tmp_path / "uav_tracking_mpc"
    native_code._MADE.clear()


def made(function):
    native = NativeFunction(function)
    if native._code.thread is not None:
        native._code.thread.join()
    assert native._code.run is not None
    return native


def test_each_operation_is_that_of_casadi_to_the_last_bit(empty):
    columns = [ca.densify(ca.vertcat(*each)) for each in (EXPRESSIONS, EXTREMES)]
    function = ca.Function("operations", [X, Y], columns)
    native, interpreted = made(function), BufferedFunction(function)
    for x in VALUES:
        for y in VALUES:
            for each in (native, interpreted):
                each.arguments[0][:], each.arguments[1][:] = x, y
                each.evaluate()
            np.testing.assert_array_equal(
                bits(native.results[0]), bits(interpreted.results[0]), err_msg=f"{x}, {y}"
            )
            np.testing.assert_array_equal(
                native.results[1], interpreted.results[1], err_msg=f"{x}, {y}"
            )


def test_the_estimate_of_the_air_is_that_of_casadi_to_the_last_bit():
    native, rng = AirEstimate()._step, np.random.default_rng(5)
    made(native.function)
    interpreted = BufferedFunction(native.function)
    for _ in range(20):
        for one, other in zip(native.arguments, interpreted.arguments, strict=True):
            one[:] = other[:] = rng.normal(size=one.size) * rng.integers(0, 2, one.size)
        native.evaluate()
        interpreted.evaluate()
        for one, other in zip(native.results, interpreted.results, strict=True):
            np.testing.assert_array_equal(bits(one), bits(other))


def test_casadi_evaluates_until_the_machine_code_is_made(empty, monkeypatch):
    may_go_on = threading.Event()
    link = MachineCode._link

    def wait(self, content):
        may_go_on.wait()
        link(self, content)

    monkeypatch.setattr(MachineCode, "_link", wait)
    native = NativeFunction(ca.Function("meanwhile", [X], [3.0 * X]))
    native.arguments[0][:] = 2.0
    native.evaluate()
    assert native._code.run is None
    assert native.results[0] == 6.0
    may_go_on.set()
    native._code.thread.join()
    native.arguments[0][:] = 3.0
    native.evaluate()
    assert native._code.run is not None
    assert native.results[0] == 9.0


@pytest.mark.parametrize("damage", [lambda content: content[:-1], lambda content: b""])
def test_it_is_kept_and_made_again_where_the_file_is_not_whole(empty, damage):
    function = ca.Function("kept", [X], [X + 1.0])
    made(function)
    (file,) = empty.iterdir()
    assert MachineCode(function).thread is None
    file.write_bytes(damage(file.read_bytes()))
    again = MachineCode(function)
    again.thread.join()
    assert again.run is not None


@pytest.mark.parametrize(
    ("step", "words"), [("_machine", "not made, CasADi goes on"), ("write", "not kept")]
)
def test_where_it_cannot_be_made_or_kept_the_function_is_evaluated(
    empty, step, words, monkeypatch, caplog
):
    def refuse(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(native_code, step, refuse)
    native = NativeFunction(ca.Function(f"without{step}", [X], [X - 1.0]))
    native._code.thread.join()
    native.arguments[0][:] = 5.0
    native.evaluate()
    assert native.results[0] == 4.0
    assert f"is {words}: the disk is full" in caplog.text


def test_an_operation_without_a_translation_is_left_to_casadi(empty):
    function = ca.Function("unknown", [X], [ca.erf(X)])
    with pytest.raises(NotImplementedError, match="operation .* has no translation"):
        MachineCode(function)
    native = NativeFunction(function)
    native.arguments[0][:] = 0.5
    native.evaluate()
    assert native.results[0] == math.erf(0.5)


def test_others_can_write_where_machine_code_of_ours_is_not_looked_for(empty):
    function = ca.Function("open", [X], [X + 2.0])
    made(function)
    empty.chmod(0o777)
    assert not code_cache.ours(empty)
    foreign = MachineCode(function)
    assert foreign.thread is not None
    foreign.thread.join()
