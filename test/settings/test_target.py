import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.target import TargetParameters


@pytest.mark.parametrize("waypoints", [(), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0) * 2])
def test_waypoints_that_are_one_point_are_refused(waypoints):
    with pytest.raises(ParameterError, match="two different points"):
        TargetParameters(waypoints=waypoints)
