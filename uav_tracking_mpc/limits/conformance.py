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

"""Whether a limit keeps what :class:`~uav_tracking_mpc.limits.Limit` asks for."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.limits import Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.conformance import judged, require, require_name
from uav_tracking_mpc.symbolic.functions import one_at_a_time

COUNT = 50  # random motions and orbits
INPUTS = {"turn_rate", "path_angle_rate", "acceleration"}


def check_limit(limit: type[Limit]) -> None:
    """Ask a limit with its default parameters about random motions and orbits.

    Args:
        limit: Class of the limit.

    Raises:
        ConformanceError: It raises, limits nothing, is not finite, has no slope somewhere, or
            differs between numbers and symbols, or between one motion and many.
    """
    name = require_name(limit)
    with judged(name):
        _check(limit())


def _check(limit: Limit) -> None:
    random = np.random.default_rng(0)
    targets = random.uniform(-100.0, 100.0, (COUNT, 3))
    numbers = np.asarray(limit.numbers(targets), dtype=float)
    require(
        numbers.ndim == 2 and len(numbers) == COUNT and np.isfinite(numbers).all(),
        f"{limit.name}: numbers() of {COUNT} targets has shape {numbers.shape}, must have "
        f"({COUNT}, k), and be finite",
    )
    span = [400.0, 400.0, 200.0, 0.5, 9.0, 0.4, 3.0, 0.2]
    motions = Motion(*random.uniform(-1.0, 1.0, (COUNT, 8)).T * np.c_[span])
    motions = motions._replace(airspeed=23.0 + motions.airspeed)
    motions.x[0] = motions.y[0] = motions.z[0] = 0.0  # at the target itself
    radius, altitude, airspeed, drift = random.uniform(
        [50.0, 0.0, 14.0, 0.0], [500.0, 200.0, 32.0, 10.0], (COUNT, 4)
    ).T
    shapes = OrbitShape(radius, altitude, airspeed, np.hypot(radius, altitude), drift)
    on_stage = _compared(limit, "stage", motions, numbers)
    on_orbit = _compared(limit, "orbit", shapes, numbers)
    bounded = [_inputs(limit, one, row) for one, row in zip(_rows(motions), numbers, strict=True)]
    require(on_stage or on_orbit or any(bounded), f"{limit.name}: it limits nothing")
    require(on_orbit or not limit.hard_on_orbit, f"{limit.name}: hard_on_orbit needs orbit()")
    flown = limit.flown(motions, numbers.T)
    if flown is not None:
        shape = np.shape(flown.passed())
        require(shape == (COUNT,), f"{limit.name}: flown() of {COUNT} motions has shape {shape}")


def _rows(many: Any) -> list[Any]:
    return [type(many)(*row) for row in np.transpose(many)]


@one_at_a_time
def _compared(limit: Limit, method: str, many: Any, numbers: NDArray[np.float64]) -> bool:
    """Whether there is a bound; in numbers it is that of the symbols, which has a slope."""
    symbols = type(many)(*(ca.SX.sym(field) for field in many._fields))
    row = ca.SX.sym("numbers", numbers.shape[1])
    bound = getattr(limit, method)(symbols, row, ca)
    if bound is None:
        return False
    words = f"{limit.name}: {method}()"
    require(isinstance(bound, Bound), f"{words} is {bound!r}, must be a Bound or None")
    require(bound.scale > 0.0, f"{words}: its scale is {bound.scale!r}, must be above 0")
    require(bound.inequalities(), f"{words} has neither a lower nor an upper bound")
    sides, seen = ca.vertcat(*bound.inequalities()), ca.vertcat(*symbols)
    function = ca.Function("bound", [seen, row], [sides, ca.jacobian(sides, seen)])
    for one, own in zip(_rows(many), numbers, strict=True):
        answer = getattr(limit, method)(one, own, np).inequalities()
        symbolic, slopes = (np.array(value) for value in function(np.array(one), own))
        where = f"{words} of {one._asdict()}"
        require(
            np.allclose(answer, symbolic.ravel(), rtol=1e-9, atol=1e-9),
            f"{where} is {answer} in numbers, {symbolic.ravel().tolist()} in symbols",
        )
        require(np.isfinite(slopes).all(), f"{where} has no slope: {slopes.tolist()}")
    return True


def _inputs(limit: Limit, motion: Motion, numbers: NDArray[np.float64]) -> bool:
    """Whether inputs are limited."""
    bounds = limit.inputs(motion, numbers, np)
    require(set(bounds) <= INPUTS, f"{limit.name}: inputs() names {sorted(bounds)}")
    for name, (lower, upper) in bounds.items():
        least = -upper if lower is None else lower
        require(least <= upper, f"{limit.name}: {name} of {motion} is {least}..{upper}")
    return bool(bounds)
