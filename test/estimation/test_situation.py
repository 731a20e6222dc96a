import numpy as np

from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation


def test_relative_velocity_is_the_rate_of_the_offset():
    """Finite difference over a steady wind and a target that moves straight."""
    vehicle = np.array([120.0, -40.0, 80.0, 0.7, 0.1, 22.0])
    target, run, wind = np.array([[10.0, 5.0, 2.0], [4.0, 1.0, 0.0], [3.0, -7.0, 0.5]])
    inputs, h = np.array([0.2, 0.05, 0.3]), 1e-4

    def offset(time):
        moved = advance(vehicle, inputs, time)
        moved[:3] += wind * time
        still = np.zeros(3)
        return Situation(moved, target + run * time, wind - run, still, inputs).offset

    now = Situation(vehicle, target, wind - run, np.zeros(3), inputs)
    rate = (offset(h) - offset(-h)) / (2 * h)
    np.testing.assert_allclose(now.relative_velocity, rate, atol=1e-6)
    np.testing.assert_allclose(now.offset, vehicle[:3] - target)
    np.testing.assert_allclose(np.linalg.norm(now.air_velocity), 22.0)
