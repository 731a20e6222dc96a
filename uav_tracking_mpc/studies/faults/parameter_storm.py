"""set_parameters on the controller from another process, with values sane and absurd.

Whatever is accepted is put back at the end. A node whose parameters are read-only refuses it all,
which is an answer too.
"""

from __future__ import annotations

import dataclasses
import random
from typing import Any

from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

from uav_tracking_mpc.parameters.specification import Specification, Value, specifications

ABSURD: tuple[Any, ...] = (
    float("nan"),
    float("inf"),
    -1e300,
    0.0,
    -1,
    2**62,
    True,
    "",
    "banana" * 100,
    [1.0],
    [float("nan")] * 5,
    ["a", "b"],
)
# What the observer holds the commands to is not widened behind its back.
LIMITS = ("yaw_rate_max", "pitch_rate_max", "acceleration_min", "acceleration_max")
BUDGET = "solve_time_max"
LEAST_BUDGETS = (1e-9, 1e-4)  # s; the least that is accepted


class ParameterStorm:
    """Client of the controller's set_parameters service.

    Args:
        node: Through which it asks.
        parameters: The dataclass whose fields are the controller's parameters, as configured.
    """

    def __init__(self, node: Node, parameters: Any) -> None:
        self._client = node.create_client(SetParameters, "nmpc_controller/set_parameters")
        self._known = specifications(type(parameters))
        self._own: dict[str, Value] = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        }
        self.asked = self.answered = self.accepted = 0

    def ask(self, values: dict[str, Any]) -> None:
        """Ask for values; the answer is counted when it comes."""
        if not self._client.service_is_ready():
            return
        request = SetParameters.Request()
        request.parameters = [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            .to_parameter_msg()
            for name, value in values.items()
        ]  # fmt: skip
        self.asked += 1
        self._client.call_async(request).add_done_callback(self._on_answer)

    def _on_answer(self, future: Any) -> None:
        answer = future.result()
        if answer is not None:
            self.answered += 1
            self.accepted += sum(result.successful for result in answer.results)

    def gust(self, rng: random.Random) -> None:
        """Ask for one to four parameters at random, at once."""
        chosen = rng.sample(self._known, rng.randint(1, 4))
        values: dict[str, Any] = {
            known.name: rng.choice(ABSURD) if rng.random() < 0.6 else self._sane(known, rng)
            for known in chosen
        }
        if rng.random() < 0.1:
            values[rng.choice(("use_sim_time", "no_such_parameter"))] = rng.choice(ABSURD)
        self.ask(values)

    def _sane(self, known: Specification, rng: random.Random) -> Value:
        own = self._own[known.name]
        if known.choices:
            return rng.choice(known.choices)
        if not isinstance(own, float):
            return own
        factor = rng.uniform(0.9, 1.0 if known.name in LIMITS else 1.1)
        return own * factor

    def starve_solver(self) -> None:
        """Ask for a time budget so small that no solve can keep it."""
        for budget in LEAST_BUDGETS[::-1]:
            self.ask({BUDGET: budget})

    def put_back(self) -> None:
        """Ask for everything as it was configured."""
        self.ask({**self._own, "use_sim_time": True})
