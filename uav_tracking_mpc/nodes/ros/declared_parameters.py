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

"""Parameter dataclasses as ROS parameters: described, ranged, checked as a whole."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes.ros.rclpy_internals import parameter_overrides
from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Parameters,
    Specification,
    from_mapping,
    specifications,
)

T = TypeVar("T", bound=Parameters)

# Known to every rclpy node; an override of one of these is no misspelling.
_BUILT_IN = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def declare_parameters(node: Node, parameters: type[T], changeable: bool = False) -> T:
    """Declare every parameter of a dataclass on a node and build it from the values.

    An integer may stand for a number (``range:=150``). Overrides that no parameter has are warned
    of.

    Args:
        node: Whose they are.
        parameters: The dataclass.
        changeable: Whether they may be set later on; see :func:`follow_parameters`. Fixed ones may
            only be set on a managed node, while it is not configured.

    Raises:
        ParameterError: A value of the wrong type, out of range, or at odds with another.
    """
    overrides = {name: _plain(value) for name, value in parameter_overrides(node).items()}
    # Limits and models may bring parameters of their own.
    parameters = parameters.extended(overrides)
    known = specifications(parameters)
    # An empty list is not set, and `ros2 param dump` writes it as null, which comes as a text.
    lists = {specification.name for specification in known if specification.default == ()}
    unset = {name for name in lists if overrides.get(name) == "null"}
    for specification in known:
        if specification.name in overrides.keys() - unset:  # before rclpy, with a better message
            specification.check(overrides[specification.name])
    values = {
        specification.name: _plain(
            node.declare_parameter(
                specification.name,
                # rclpy would call an empty list one of bytes.
                None if specification.default == () else ros_value(specification.default),
                _descriptor(specification, changeable, isinstance(node, LifecycleNode)),
                ignore_override=specification.name in unset,
            ).value
        )
        for specification in known
    }
    names = {specification.name for specification in known}
    for name in overrides:
        if name not in names and not name.startswith(_BUILT_IN):
            node.get_logger().warning(
                f"parameter '{name}' is unknown and has no effect; known are: "
                f"{', '.join(sorted(names))}"
            )
    return from_mapping(parameters, values)


def follow_parameters(
    node: Node, parameters: T, check: Callable[[T], None], take: Callable[[T], None]
) -> None:
    """Let the parameters of a dataclass be set while the node runs, together or not at all.

    Args:
        node: On which they have been declared as changeable.
        parameters: As :func:`declare_parameters` has built them.
        check: Raises ParameterError where the whole set cannot be taken now.
        take: Takes it; called after every parameter has its new value.
    """
    kind = type(parameters)
    names = {specification.name for specification in specifications(kind)}
    present, agreed = parameters, parameters  # what is flown by, and what has been checked last

    def on_set(changes: list[Parameter]) -> SetParametersResult:
        nonlocal agreed
        agreed = present
        asked = {change.name: _plain(change.value) for change in changes if change.name in names}
        if all(_same(value, getattr(present, name)) for name, value in asked.items()):
            return SetParametersResult(successful=True)
        values = {name: _plain(node.get_parameter(name).value) for name in names}
        try:
            candidate = from_mapping(kind, values | asked)
            check(candidate)
        except Exception as error:  # whatever a user's extension raises, the node goes on
            return SetParametersResult(successful=False, reason=str(error))
        agreed = candidate
        return SetParametersResult(successful=True)

    def after_set(_: list[Parameter]) -> None:
        nonlocal present
        if agreed is not present:
            present = agreed
            try:
                take(present)
            except Exception as error:  # of a user's extension: whoever flies flies on
                node.get_logger().error(f"the parameters are set, and taken in part: {error}")

    node.add_on_set_parameters_callback(on_set)
    node.add_post_set_parameters_callback(after_set)


def _descriptor(
    specification: Specification, changeable: bool, managed: bool
) -> ParameterDescriptor:
    unit = f" [{specification.unit}]" if specification.unit else ""
    constraints = f"must be {specification.allowed}"
    read_only = not changeable or (specification.fixed and not managed)
    if specification.fixed and not read_only:
        constraints += "; stays as it is while the node is configured"
    descriptor = ParameterDescriptor(
        description=specification.description + unit,
        additional_constraints=constraints,
        read_only=read_only,
        dynamic_typing=True,
    )
    lower, upper = specification.lower, specification.upper
    if isinstance(specification.default, float):
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-math.inf if lower is None else float(lower),
                to_value=math.inf if upper is None else float(upper),
                step=0.0,
            )
        ]
    elif isinstance(specification.default, int) and not isinstance(specification.default, bool):
        if lower is None or upper is None:
            raise ParameterError(f"integer parameter '{specification.name}' needs both limits")
        descriptor.integer_range = [
            IntegerRange(from_value=int(lower), to_value=int(upper), step=1)
        ]
    return descriptor


def ros_value(value: Any) -> Any:
    """A value as ROS takes it: a list of numbers holds floats alone.

    Args:
        value: Of a parameter.
    """
    if isinstance(value, (tuple, list, np.ndarray)):
        return [float(number) for number in value]
    return value.item() if isinstance(value, np.generic) else value


def _same(value: Any, present: Any) -> bool:
    """Whether a value is the present one, of the same type."""
    return repr(value) == repr(_plain(ros_value(present)))


def _plain(value: Any) -> Any:
    if value is None:
        return []  # how rclpy hands over an empty list
    return list(value) if hasattr(value, "tolist") else value
