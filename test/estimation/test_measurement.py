import numpy as np
import pytest

from uav_tracking_mpc.estimation.measurement import Measurement


def test_the_state_has_the_airspeed_that_it_is_given():
    measurement = Measurement(1.0, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0.7, 0.1)
    np.testing.assert_array_equal(measurement.state(22.0), [1.0, 2.0, 3.0, 0.7, 0.1, 22.0])


def test_what_it_was_made_from_may_change_afterwards():
    position = np.zeros(3)
    measurement = Measurement(1.0, position, np.zeros(3), 0.0, 0.0)
    position += 5.0
    np.testing.assert_array_equal(measurement.position, np.zeros(3))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"stamp": np.nan}, "stamp is nan, must be a finite number"),
        ({"position": [0.0, 1.0]}, r"position is \[0.0, 1.0\], must be three finite numbers"),
        ({"ground_velocity": [0.0, np.inf, 0.0]}, "ground_velocity is .*inf"),
        ({"airspeed": -np.inf}, "airspeed is -inf"),
        ({"turn_rate": np.nan}, "turn_rate is nan"),
    ],
)
def test_what_is_no_measurement_is_refused(values, words):
    good = {"stamp": 0.0, "position": np.zeros(3), "ground_velocity": np.zeros(3)}
    with pytest.raises(ValueError, match=words):
        Measurement(**{**good, "heading": 0.0, "path_angle": 0.0, **values})
