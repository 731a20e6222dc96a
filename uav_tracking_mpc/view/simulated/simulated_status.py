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

"""What controller, plant and target of a simulation say of themselves, as their nodes would."""

from __future__ import annotations

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.view.sight import NodeStatus
from uav_tracking_mpc.view.simulated.interrupted_loop import KILLED, InterruptedLoop
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR, TARGET

OK, WARNING, ERROR, SILENT = range(4)


def statuses(loop: InterruptedLoop) -> tuple[NodeStatus, ...]:
    """One of each, as it is now.

    Args:
        loop: That is flown.
    """
    return _controller(loop), _simulator(loop), _target(loop)


def _controller(loop: InterruptedLoop) -> NodeStatus:
    if loop.killed:
        return NodeStatus(CONTROLLER, SILENT, KILLED)
    controller = loop.controller
    mode, reason, counts = controller.modes.mode, controller.modes.reason, controller.modes.counts
    east, north, up = controller.drift.tolist()
    formulation = controller.formulation
    values = {
        "mode changes": f"{controller.modes.changes}",
        **{f"mode {each.value}": f"{count}" for each, count in counts.items()},
        "solver": "none" if formulation is None else formulation.solver.name,
        "drift east [m/s]": f"{east:.2f}",
        "drift north [m/s]": f"{north:.2f}",
        "drift up [m/s]": f"{up:.2f}",
        "target noise [m]": f"{controller.navigator.target.noise:.3g}",
        "target positions rejected": f"{controller.navigator.target.rejected}",
    }
    if mode is FallbackMode.SILENCE:
        level, words = ERROR if loop.commanded else WARNING, f"{reason}: no command is sent"
    elif mode is FallbackMode.HOLD:
        level, words = ERROR, f"{reason}: wings level"
    elif not mode.nominal:
        level = WARNING if mode.planned else ERROR
        words = f"flying {mode.value}, not the optimal one: {reason}"
    else:
        level, words = OK, f"tracking: {mode.value}"
    return NodeStatus(CONTROLLER, level, words, values)


def _simulator(loop: InterruptedLoop) -> NodeStatus:
    plan, speed = loop.plant.plan, loop.plant.parameters.speed
    east, north, up = loop.plant.wind.tolist()
    values = {
        "wind east [m/s]": f"{east:.2f}",
        "wind north [m/s]": f"{north:.2f}",
        "wind up [m/s]": f"{up:.2f}",
        "speed": f"{speed:g}",
        "failsafe": f"{plan.failsafes}",
    }
    if not plan.commanded:
        return NodeStatus(SIMULATOR, WARNING, "waiting for the first command", values)
    if plan.holding:
        words = "no plan left to fly: holding wings level until a command comes"
        return NodeStatus(SIMULATOR, WARNING, words, values)
    return NodeStatus(SIMULATOR, OK, "flying on commands", values)


def _target(loop: InterruptedLoop) -> NodeStatus:
    motion, place = loop.target.parameters.motion, loop.target.heading_for(loop.time)
    if place is None:
        return NodeStatus(TARGET, OK, f"target is {motion}")
    x, y, z = place.tolist()
    words = f"target drives to ({x:.6g}, {y:.6g}, {z:.6g}), then is {motion}"
    return NodeStatus(TARGET, OK, words)
