import numpy as np

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions.stationary import Stationary


def test_it_stands_whatever_its_speed():
    target = Stationary(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0))
    np.testing.assert_array_equal(target.position(9.0), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(target.velocity(9.0), np.zeros(3))
