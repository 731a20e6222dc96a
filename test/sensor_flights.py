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

"""Random flights, in which nothing fails or one sensor does."""

import dataclasses
import math

import numpy as np

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.estimation.sensor_health import USED
from uav_tracking_mpc.limits import TOLERANCE
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.studies.comparison.measures import SHAKEN

BEGIN = 90.0  # s, of what fails
AFTER = 60.0  # s, that are flown with it


def either(random, least, greatest):
    return random.choice([-1.0, 1.0]) * random.uniform(least, greatest)


# By the sensor that is to be named: parameters of the simulator from the begin on.
FAULTS = {
    "stuck": ("airspeed", lambda r: {"airspeed_fault": "stuck", "airspeed_bias": either(r, 2, 6)}),
    "off": ("airspeed", lambda r: {"airspeed_bias": either(r, 4, 8)}),
    "zero": ("airspeed", lambda r: {"airspeed_bias": -50.0}),
    "silent": ("airspeed", lambda r: {"airspeed_fault": "silent"}),
    "turned": ("heading", lambda r: {"heading_bias": either(r, 0.35, 3.0)}),
    "held": ("heading", lambda r: {"heading_fault": "stuck"}),
    "still": ("ground velocity", lambda r: {"velocity_fault": "stuck"}),
    "reversed": ("ground velocity", lambda r: {"velocity_gain": -1.0}),
    "frozen": ("position", lambda r: {"position_fault": "frozen"}),
    "lost": ("position", lambda r: {"position_fault": "silent"}),
    "moved": ("position", lambda r: {"position_bias": [*r.uniform(6.0, 20.0, 2).tolist(), 0.0]}),
}


def flown(seed, name, plant, begin, end):
    """News of the sensors, least and greatest airspeed, and whether gusts blow, of a random flight.

    Near the least airspeed (14 m/s) and the greatest (32), too.
    """
    random, orbits = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    wind, direction = random.uniform(0.0, 8.0), random.uniform(-math.pi, math.pi)
    simulator = {
        "wind": [wind * math.cos(direction), wind * math.sin(direction), 0.0],
        "seed": seed,
        "gust_intensity": random.choice([0.0, 7.7, 15.4]),
        "airspeed_noise": random.choice([0.0, 0.3]),
        "velocity_noise": random.choice([0.0, 0.2]),
        "attitude_noise": random.choice([0.0, 0.005]),
    }
    changes = [f"uav_simulator.{key}={value}" for key, value in simulator.items()]
    changes += [
        "target_publisher.motion=line",
        f"target_publisher.speed={random.uniform(0.0, 4.0)}",
        f"target_publisher.heading={random.uniform(-3.0, 3.0)}",
        f"nmpc_controller.range={random.uniform(200.0, 350.0)}",
        # The rigid aircraft has other limits than the controller is told here.
        f"nmpc_controller.airspeed={orbits.uniform(15.5, 29.0) if plant == 'vehicle' else 22.0}",
        "nmpc_controller.solve_time_max=10.0",
        f"mission.plant={plant}",
    ]
    fails = FAULTS[name][1](random) if name else {}
    wrong = tuple((begin, f"uav_simulator.{key}={value}") for key, value in fails.items())
    loop = ClosedLoop(dataclasses.replace(load_configuration("small_uav", changes), changes=wrong))
    airspeeds = []
    while loop.time < end:
        airspeeds.append(loop.tick().truth.airspeed)
    news = [(each.time, each.sensor, each.state) for each in loop.log(end).sensors]
    return news, min(airspeeds), max(airspeeds), simulator["gust_intensity"] > 0.0


def named_rightly(name, news, begin):
    """Whether the sensor that fails is named, after it fails, and no other."""
    wrong = [(time, sensor) for time, sensor, state in news if state != USED]
    if not name:
        return not wrong
    return bool(wrong) and all(each == FAULTS[name][0] and time >= begin for time, each in wrong)


def judged(seed, name, plant="vehicle", begin=BEGIN):
    news, slowest, fastest, gusty = flown(seed, name, plant, begin, begin + AFTER)
    beyond = SHAKEN if gusty else TOLERANCE  # of the limits of small_uav, from which on it counts
    told = seed, name, plant, slowest, fastest
    assert (1.0 - beyond) * 14.0 <= slowest <= fastest <= (1.0 + beyond) * 32.0, told
    return named_rightly(name, news, begin)
