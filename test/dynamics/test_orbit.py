import numpy as np
import pytest

from uav_tracking_mpc.dynamics.orbit import Orbit


def test_radius_is_the_horizontal_distance(orbit):
    assert orbit.radius == pytest.approx(np.sqrt(150.0**2 - 50.0**2))


def test_direction_chooses_the_bearing(orbit):
    assert orbit.steady_state == pytest.approx([150.0, np.pi / 2, 50.0, 0.0, 4.0])
    assert Orbit(150.0, 50.0, 4.0, "counter_clockwise").bearing == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ((50.0, 50.0, 4.0), "range is 50.0"),
        ((40.0, -50.0, 4.0), "range is 40.0"),
        ((np.nan, 50.0, 4.0), "range is nan"),
        ((150.0, np.inf, 4.0), "altitude is inf"),
        ((150.0, 50.0, 0.0), "speed is 0.0"),
        ((150.0, 50.0, 4.0, "left"), "direction is 'left'"),
    ],
)
def test_what_is_no_orbit_is_refused_by_name_and_value(values, name):
    with pytest.raises(ValueError, match=name):
        Orbit(*values)
