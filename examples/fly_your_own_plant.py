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

"""Fly your own plant: the controller in a loop of your own, without ROS and without our simulator.

``step`` takes what your sensors say and answers with what to fly, or None while there is nothing to
answer. What the aircraft does with the command is up to you: here, thirty lines of point mass.
"""

import math

import numpy as np

from uav_tracking_mpc import Controller, Measurement, load_configuration

TICK = 0.05  # s
TARGET = np.array([0.0, 0.0, 0.0])


def fly(duration: float = 60.0) -> np.ndarray:
    """Distance to the target at every tick in [m], shape (n,)."""
    # Simulated time waits for answers, and solves may take their time: each flight is the same.
    patient = "nmpc_controller.solve_time_max=10.0"
    parameters = load_configuration("small_uav", [patient]).controller
    controller = Controller(parameters, stopwatch=lambda: 0.0)
    position, heading, path_angle, speed = np.array([600.0, 0.0, 100.0]), math.pi, 0.0, 22.0
    turn_rate, path_rate, acceleration = 0.0, 0.0, 0.0
    distances = []
    for now in TICK * np.arange(round(duration / TICK)):
        across = math.cos(path_angle)
        direction = [across * math.cos(heading), across * math.sin(heading), math.sin(path_angle)]
        velocity = speed * np.array(direction)
        controller.see_target(now, TARGET)
        measurement = Measurement(now, position, velocity, heading, path_angle, airspeed=speed)
        command = controller.step(measurement, now)
        if command is not None:
            turn_rate, path_rate, acceleration = command.inputs[0]
        position = position + TICK * velocity
        heading = math.remainder(heading + TICK * turn_rate, math.tau)
        path_angle += TICK * path_rate
        speed += TICK * acceleration
        distances.append(math.dist(position, TARGET))
    return np.array(distances)


if __name__ == "__main__":
    flown = fly()
    print(f"from {flown[0]:.1f} m to {flown[-1]:.1f} m; asked for are 300 m")
