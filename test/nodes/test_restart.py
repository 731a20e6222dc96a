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

"""The controller is gone in mid-turn: the vehicle goes on, and a new one takes over."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from uav_tracking_mpc.nodes.messages.conversions import measurement_from_odometry, plan_from_command
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

pytestmark = pytest.mark.nodes


def kill(flight):
    """As SIGKILL: nothing is said and nothing is let go."""
    flight.made.remove(flight.controller)
    flight.executor.remove_node(flight.controller)
    flight.controller.destroy_node()


def flown(flight):
    """The latest state."""
    return measurement_from_odometry(flight.states[-1])


def error(flight):
    """Of range or altitude about the target, which stands at the origin, in [m]."""
    position, orbit = flown(flight).position, flight.configuration.controller.orbit
    return max(abs(np.linalg.norm(position) - orbit.range), abs(position[2] - orbit.altitude))


def restart(flight):
    """Start a new controller; how far its first command is from what is flown."""
    flight.commands.clear()
    parameters = flight.configuration.controller
    flight.controller = flight.add(NmpcController, **asdict(parameters), use_sim_time=True)
    assert flight.spin(lambda: flight.commands)
    plan, _ = plan_from_command(flight.commands[0])
    assert np.all(plan <= parameters.input_upper + 1e-9)
    assert np.all(plan >= parameters.input_lower - 1e-9)
    assert np.all(np.abs(plan[:, 0]) <= parameters.envelope.turn_rate_max(21.0))
    return np.abs(plan[0, :2] - [flown(flight).turn_rate, flown(flight).path_angle_rate])


def test_a_new_controller_takes_over_in_mid_turn_and_after_the_plan_has_ended(flying):
    assert flying.commanded(60)
    assert abs(flown(flying).turn_rate) > 0.05

    # At once: the vehicle still flies the plan of the one that is gone.
    kill(flying)
    step = restart(flying)
    plan = flying.simulator._plant.plan
    assert not plan.holding
    assert abs(flown(flying).turn_rate) > 0.05
    envelope = flying.configuration.controller.envelope
    assert step[0] < 0.5 * envelope.turn_rate_max(22.0)
    assert error(flying) < 10.0

    # Late: the plan is flown to its end, then the wings are level.
    assert flying.commanded(60)
    kill(flying)
    killed = flying.simulator._now
    words = "nobody publishes uav/command any more"
    assert flying.spin(lambda: words in [said.message for said in flying.says("uav_simulator")])
    assert flying.spin(lambda: plan.holding)
    parameters = flying.configuration.controller
    length = parameters.horizon * parameters.horizon_step
    assert length - 2.0 < (flying.simulator._now - killed) * 1e-9 < length + 2.0
    assert flying.spin(lambda: abs(flown(flying).turn_rate) < 0.01)
    flying.fly(5.0)  # a hundred metres and more along the tangent
    restart(flying)
    assert error(flying) > 10.0
    assert flying.spin(lambda: error(flying) < 10.0)
