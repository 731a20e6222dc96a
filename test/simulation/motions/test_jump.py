import numpy as np

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions.jump import Jump


def test_it_is_elsewhere_at_once_and_drives_on():
    parameters = TargetParameters(
        position=(1.0, 2.0, 3.0), speed=5.0, jump_time=10.0, jump_offset=(-100.0, 50.0, 5.0)
    )
    target = Jump(parameters)
    np.testing.assert_allclose(target.position(10.0 - 1e-9), [51.0, 2.0, 3.0], atol=1e-6)
    np.testing.assert_allclose(target.position(10.0), [-49.0, 52.0, 8.0])
    np.testing.assert_allclose(target.position(11.0), [-44.0, 52.0, 8.0])
    np.testing.assert_array_equal(target.velocity(10.0), [5.0, 0.0, 0.0])
