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

"""Models of the aircraft for the prediction of a real flight.

===============  ===================================================================
``lagged``       the vehicle (3) behind inner loops that lag, in a drift; the same
                 where the autopilot itself holds altitude and airspeed
``conformance``  whether a model keeps what the base asks for
===============  ===================================================================

A model is a subclass of :class:`VehicleModel` with a name. Its fields are parameters of the
controller.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import OrbitMotion
from uav_tracking_mpc.parameters.registry import ExtensionPoint
from uav_tracking_mpc.parameters.specification import Parameters


class Drift(NamedTuple):
    """The air as seen from the target.

    Attributes:
        velocity: c at the beginning of a step, three values in [m/s]: numbers or symbols.
        rate: c', three values in [m/s^2], constant over the step.
    """

    velocity: Any
    rate: Any


class VehicleState(NamedTuple):
    """State of the aircraft that every model begins with, relative to the target.

    Numbers or symbols.

    Attributes:
        x: East of the target in [m].
        y: North of the target in [m].
        z: Above the target in [m].
        heading: psi in [rad].
        path_angle: chi in [rad].
        airspeed: v in [m/s].
        turn_rate: psi' in [rad/s].
        path_angle_rate: chi' in [rad/s].
        acceleration: v' in [m/s^2].
    """

    x: Any
    y: Any
    z: Any
    heading: Any
    path_angle: Any
    airspeed: Any
    turn_rate: Any
    path_angle_rate: Any
    acceleration: Any


@dataclass(frozen=True)
class VehicleModel(Parameters, ABC):
    """Base of the models.

    A model says how the state moves on over a step (:meth:`step`), what of that changes in flight
    (:meth:`numbers`), and how slowly its rates follow commands (:attr:`lags`). One with further
    components names them in a ``State`` of its own, which begins with those of
    :class:`VehicleState`, and says in :meth:`initial` and :meth:`settled` what they are at a
    measured state and on an orbit.

    Attributes:
        name: By which it is found.
        State: NamedTuple of the state's components.
        commanded: How many of (u_psi, u_chi, u_v), from the first on, the controller commands; the
            autopilot finds the others itself, see :meth:`held`.
    """

    name: ClassVar[str]
    State: ClassVar[Any] = VehicleState
    commanded: ClassVar[int] = 3

    @abstractmethod
    def numbers(self, duration: float) -> NDArray[np.float64]:
        """What a step is told of this model, shape (k,): may change in flight.

        Args:
            duration: Of the step in [s], positive.
        """

    @property
    @abstractmethod
    def lags(self) -> NDArray[np.float64]:
        """Time constants with which (psi', chi', v') follow commands, shape (3,), in [s]."""

    def with_lags(self, lags: NDArray[np.float64]) -> VehicleModel:
        """This model with other time constants; itself where they cannot be changed, by default.

        Args:
            lags: As of :attr:`lags`, shape (3,), in [s].
        """
        return self

    @abstractmethod
    def step(self, state: Any, inputs: Any, duration: Any, numbers: Any, drift: Drift) -> Any:
        """State after a step under held inputs, for numbers and CasADi symbols alike.

        Args:
            state: A ``State``.
            inputs: (u_psi, u_chi, u_v), three values in [rad/s, rad/s, m/s^2].
            duration: In [s].
            numbers: Of this duration, as of :meth:`numbers`, shape (k,).
            drift: Of the air as seen from the target.

        Returns:
            A ``State``; angles are not wrapped.
        """

    def held(self, state: Any, altitude: Any, airspeed: Any, numbers: Any, drift: Any) -> list[Any]:
        """Inputs that the autopilot finds itself: none by default.

        Args:
            state: A ``State`` of numbers, of arrays of shape (n,), or of symbols.
            altitude: Above the target that the autopilot holds in [m], scalar.
            airspeed: That the autopilot holds in [m/s], scalar.
            numbers: As of :meth:`numbers`, shape (k,).
            drift: c, three values in [m/s], each like the state's.

        Returns:
            (u_psi, u_chi, u_v) without the first :attr:`commanded`.
        """
        return []

    def initial(self, vehicle: ArrayLike, target: ArrayLike, rates: ArrayLike) -> Any:
        """State of a measured motion; a model with further components overrides it.

        Args:
            vehicle: (x, y, z, psi, chi, v) in ``map``, shape (6,).
            target: Position in ``map``, shape (3,), in [m].
            rates: (psi', chi', v'), shape (3,), in [rad/s, rad/s, m/s^2].

        Returns:
            A ``State`` of floats.
        """
        x, y, z, *motion = np.asarray(vehicle, dtype=float).tolist()
        east, north, up = np.asarray(target, dtype=float).tolist()
        turning = np.asarray(rates, dtype=float).tolist()
        return self.State(x - east, y - north, z - up, *motion, *turning)

    def settled(self, state: Any, orbit: OrbitMotion) -> list[Any]:
        """What must vanish, beside position and velocity, for the state to be on an orbit.

        By default the rates are those of the orbit; further components need more.

        Args:
            state: A ``State`` of symbols.
            orbit: Motion on the orbit where the aircraft is.
        """
        return [state.turn_rate - orbit.turn_rate, state.path_angle_rate, state.acceleration]


VEHICLE_MODEL = ExtensionPoint("model of the vehicle", VehicleModel)


def step_function(model: VehicleModel) -> ca.Function:
    """A step of a model as a CasADi function; what changes in flight enters by its numbers.

    Args:
        model: Of the aircraft.

    Returns:
        Of the state, shape (nx,), (u_psi, u_chi, u_v), the model's numbers, c and c', shape (3,)
        each, and the duration [s]: the state after it, shape (nx,).
    """
    state = model.State(*(ca.SX.sym(name) for name in model.State._fields))
    inputs, drift, rate = (ca.SX.sym(name, 3) for name in ("u", "c", "c_rate"))
    numbers, duration = ca.SX.sym("numbers", len(model.numbers(1.0))), ca.SX.sym("t")
    moved = Drift(ca.vertsplit(drift), ca.vertsplit(rate))
    following = ca.vertcat(*model.step(state, inputs, duration, numbers, moved))
    told = [ca.vertcat(*state), inputs, numbers, drift, rate, duration]
    return ca.Function("step", told, [ca.densify(following)])
