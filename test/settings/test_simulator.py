import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"speed_min": 9.0, "speed_max": 8.0}, "speed_min"),
        ({"initial_speed": 30.0}, "initial_speed"),
    ],
)
def test_limits_that_do_not_fit_are_named(values, name):
    with pytest.raises(ParameterError, match=name):
        SimulatorParameters(**values)
