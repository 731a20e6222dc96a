"""A loiter law flown without a simulator: the exact vehicle, 20 Hz, perfect knowledge."""

import numpy as np

from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.limits._envelope import Envelope

STEP = 0.05
SMALL_UAV = Envelope(
    airspeed_min=14.0,
    airspeed_max=32.0,
    path_angle_min=np.radians(-9.0),
    path_angle_max=np.radians(14.0),
    bank_max=np.radians(45.0),
    yaw_rate_max=0.785,
    pitch_rate_max=0.785,
    acceleration_min=-1.5,
    acceleration_max=3.0,
    force_min=(-1.5, -4.0),
    force_max=(4.0, 2.5),
    height_min=30.0,
)


def fly(law, start, duration, wind=(0.0, 0.0, 0.0), target_velocity=(0.0, 0.0, 0.0)):
    """Offsets from the target (n, 3), vehicle states (n, 6) and inputs (n, 3)."""
    vehicle, target = np.array(start, dtype=float), np.zeros(3)
    wind, run, rates = np.array(wind), np.array(target_velocity), np.zeros(3)
    offsets, vehicles, inputs = [], [], []
    for _ in range(round(duration / STEP)):
        situation = Situation(vehicle, target, wind - run, np.zeros(3), rates)
        rates = law.inputs(situation)
        offsets.append(situation.offset)
        vehicles.append(vehicle)
        inputs.append(rates)
        vehicle = advance(vehicle, rates, STEP)
        vehicle[:3] += STEP * wind
        target = target + STEP * run
    return np.array(offsets), np.array(vehicles), np.array(inputs)


def range_errors(law, offsets):
    return np.linalg.norm(offsets, axis=1) - law.orbit.range
