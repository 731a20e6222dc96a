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

"""Fly an aircraft over a link: here a simulated one, later an autopilot behind a radio.

A link gives measurements and takes commands, and refuses in words what its aircraft does not fly.
Another autopilot is another subclass of ``VehicleLink``; the loop stays the same.
"""

from uav_tracking_mpc import Controller, VehicleLink, check_link, load_configuration
from uav_tracking_mpc.links.simulated import SimulatedLink

TARGET = (0.0, 0.0, 0.0)


def fly(link: VehicleLink, controller: Controller, duration: float) -> float:
    """Fly about the target.

    Args:
        link: To the aircraft.
        controller: Of its flight.
        duration: For how long in [s].

    Returns:
        Error of the range at the end in [m].
    """
    with link:
        end = link.now() + duration
        while link.now() < end:
            state = link.measured(timeout=0.5)
            if state is None:
                continue  # the aircraft flies its plan on: see link.when_silent
            controller.see_target(state.stamp, TARGET)
            command = controller.step(state, link.now())
            if command is not None:
                refusal = link.command(command.stamp, command.inputs, command.step)
                if refusal:
                    print(f"refused: {refusal}")
        distance = float((state.position**2).sum() ** 0.5)
    return distance - controller.orbit.range


if __name__ == "__main__":
    check_link(SimulatedLink)
    small_uav = load_configuration("small_uav")
    aircraft = SimulatedLink(parameters=small_uav.simulator)
    error = fly(aircraft, Controller(small_uav.controller), duration=60.0)
    print(f"{error:.3f} m from the orbit; left alone, the aircraft {aircraft.when_silent}")
