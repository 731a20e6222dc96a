"""A bag written message by message and read back as the record of a flight."""

import numpy as np
import pytest
from rclpy.serialization import serialize_message

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes.conversions import set_air_velocity, set_command, set_odometry
from uav_tracking_mpc.nodes.flight_bag import FlightBag, flight_log
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY
from uav_tracking_mpc.settings.configuration import load_configuration

WIND = np.array([3.0, -2.0, 0.5])
STEP = 50_000_000  # ns


def states():
    for k in range(20):
        yield k * STEP, np.array([200.0 - k, 3.0 * k, 50.0, 0.1 * k, 0.05, 20.0 + 0.1 * k])


def fly(path, air=lambda k: True):
    bag = FlightBag(path)
    for k, (stamp, state) in enumerate(states()):
        message = ODOMETRY.type()
        set_odometry(message, stamp, state, np.zeros(3), velocity(state) + WIND)
        bag.write(ODOMETRY, stamp + 1, serialize_message(message))
        if air(k):
            message = AIR_VELOCITY.type()
            set_air_velocity(message, stamp, state[5])
            bag.write(AIR_VELOCITY, stamp + 2, serialize_message(message))
        if k == 0:
            message = COMMAND.type()
            set_command(message, stamp, np.zeros((2, 3)), 1.0)
            bag.write(COMMAND, stamp + 3, serialize_message(message))
    bag.close()
    configuration = load_configuration(
        "paper", ["target_publisher.motion=line", "target_publisher.speed=2.0"]
    )
    return flight_log(path, configuration)


@pytest.mark.parametrize("air", [lambda k: True, lambda k: k % 3 == 0 or k == 19])
def test_the_vehicles_speed_is_that_through_the_air(tmp_path, air):
    """Also where some of the airspeeds are missing."""
    log = fly(tmp_path / "flight.mcap", air)
    expected = np.array([state for _, state in states()])
    np.testing.assert_allclose(log.vehicle, expected, atol=1e-7)
    np.testing.assert_allclose(
        log.ground_velocity, [velocity(state) + WIND for state in expected], atol=1e-7
    )
    np.testing.assert_array_equal(log.target_velocity, [[2.0, 0.0, 0.0]] * 20)
    np.testing.assert_allclose(log.target[:, 0], 2.0 * log.time)


def test_without_an_airspeed_the_air_is_taken_as_still(tmp_path):
    log = fly(tmp_path / "flight.mcap", air=lambda k: False)
    np.testing.assert_allclose(log.vehicle[:, 5], np.linalg.norm(log.ground_velocity, axis=1))
