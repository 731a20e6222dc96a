import numpy as np
import pytest

from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.parameters import ParameterError


def test_defaults_are_table_1():
    parameters = TrackingParameters()
    assert parameters.orbit.steady_state == pytest.approx([150.0, np.pi / 2, 50.0, 0.0, 4.0])
    assert parameters.state_weights == (0.008, 0.09, 0.05, 0.04, 0.9)
    assert (parameters.horizon, parameters.horizon_step) == (10, 1.0)
    assert parameters.terminal_scaling == 2.5


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"range": 40.0}, "range is 40.0 m"),
        ({"yaw_rate_max": 0.02}, "'yaw_rate_max' is 0.02, must exceed 0.0282843"),
        ({"airspeed": 200.0}, "steady turn rate of an orbit of radius 141.421 m at 200 m/s"),
    ],
)
def test_values_that_do_not_fit_together_are_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        TrackingParameters(**values)


def test_bounds_are_ordered_as_the_inputs():
    parameters = TrackingParameters(
        yaw_rate_max=0.5, pitch_rate_max=0.2, acceleration_min=-2.0, acceleration_max=3.0
    )
    assert parameters.input_lower == pytest.approx([-0.5, -0.2, -2.0])
    assert parameters.input_upper == pytest.approx([0.5, 0.2, 3.0])
