import numpy as np

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions.line import Line


def test_it_runs_straight_towards_its_heading():
    line = Line(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0, heading=np.pi / 2))
    np.testing.assert_allclose(line.position(4.0), [1.0, 22.0, 3.0])
    np.testing.assert_allclose(line.velocity(4.0), [0.0, 5.0, 0.0], atol=1e-12)
