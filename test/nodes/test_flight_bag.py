"""A bag written message by message and read back as the record of a flight."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes.conversions import (
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
)
from uav_tracking_mpc.nodes.flight_bag import FlightBag, flight_log
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    TARGET,
)
from uav_tracking_mpc.settings.configuration import load_configuration

WIND = np.array([3.0, -2.0, 0.5])
STEP = 50_000_000  # ns
WALL = 1_700_000_000_000_000_000  # ns


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


def fly_with_link(path, engaged=True, target_system=0):
    """The flight of above by wall time, engaged at its fifth state; the target began before it."""
    bag = FlightBag(path)

    def write(topic, message, stamp):
        bag.write(topic, stamp + 1, serialize_message(message))

    for k, (stamp, state) in enumerate(states()):
        stamp += WALL
        odometry, command, seen = ODOMETRY.type(), COMMAND.type(), TARGET.type()
        set_odometry(odometry, stamp, state, np.zeros(3), velocity(state))
        set_command(command, stamp, np.zeros((2, 3)), 1.0)
        set_point(seen, stamp, np.array([0.1 * k, 0.0, 0.0]))
        for topic, message in ((ODOMETRY, odometry), (COMMAND, command), (TARGET, seen)):
            write(topic, message, stamp)
        write(ENGAGED, ENGAGED.type(data=engaged and k >= 5), stamp - 2)
    values = {"dialect": "ardupilot", "rate [Hz]": 50.0, "latency median [ms]": 2.5}
    values |= {"messages lost": 3, "commands refused": 1, "plans refused": 2}
    for name, entries in {
        "autopilot_link": values,
        "target_publisher": {"began [ns]": WALL - 10 * STEP},
    }.items():
        entries = [KeyValue(key=key, value=str(value)) for key, value in entries.items()]
        status = DiagnosticStatus(name=f"{name}: status", values=entries)
        write(DIAGNOSTICS, DIAGNOSTICS.type(status=[status]), WALL)
    bag.close()
    overrides = ["target_publisher.motion=line", "target_publisher.speed=2.0"]
    overrides += ["autopilot_link.link=ardupilot", f"autopilot_link.target_system={target_system}"]
    return flight_log(path, load_configuration("paper", overrides))


def test_with_a_link_a_flight_begins_when_it_is_engaged(tmp_path):
    log = fly_with_link(tmp_path / "flight.mcap")
    np.testing.assert_allclose(log.time, STEP * 1e-9 * np.arange(15), atol=1e-6)
    np.testing.assert_allclose(log.command_time, log.time)
    assert log.vehicle[0, 0] == 195.0
    assert log.plant == "ardupilot"
    assert log.link.dialect == "ardupilot"
    assert (log.link.rate, log.link.latency, log.link.lost, log.link.refused) == (50.0, 2.5, 3, 3)
    assert np.isnan(log.link.latency_p99)


def test_with_a_link_the_target_began_when_its_node_did(tmp_path):
    log = fly_with_link(tmp_path / "flight.mcap")
    np.testing.assert_allclose(log.target[:, 0], 2.0 * (log.time + 15 * STEP * 1e-9), atol=1e-6)


def test_a_target_on_the_link_is_where_it_said(tmp_path):
    log = fly_with_link(tmp_path / "flight.mcap", target_system=2)
    np.testing.assert_allclose(log.target[:, 0], 0.1 * np.arange(5, 20), atol=1e-6)
    np.testing.assert_allclose(log.target_velocity[:, 0], 2.0, atol=1e-6)


def test_an_autopilot_that_was_never_engaged_did_not_fly(tmp_path):
    with pytest.raises(ValueError, match="never engaged"):
        fly_with_link(tmp_path / "flight.mcap", engaged=False)
