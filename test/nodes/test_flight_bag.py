# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A bag written message by message and read back as the record of a flight."""

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.bag.bag_log import flight_log
from uav_tracking_mpc.nodes.bag.flight_bag import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import (
    set_air_velocity,
    set_command,
    set_measurement,
    set_odometry,
    set_point,
)
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    ROSOUT,
    TARGET,
)
from uav_tracking_mpc.report.metrics import metrics, verdict
from uav_tracking_mpc.settings.configuration import load_configuration

WIND = np.array([3.0, -2.0, 0.5])
STEP = 50_000_000  # ns
ROSBAG = "rosbag2_bagfile_information"
WALL = 1_700_000_000_000_000_000  # ns


def states():
    for k in range(20):
        yield k * STEP, np.array([200.0 - k, 3.0 * k, 50.0, 0.1 * k, 0.05, 20.0 + 0.1 * k])


def fly(path, air=lambda k: True, bank=None, astray=()):
    bag = FlightBag(path)
    for k, (stamp, state) in enumerate(states()):
        message = ODOMETRY.type()
        if bank is None:
            set_odometry(message, stamp, state, np.zeros(3), velocity(state) + WIND)
        else:
            *place, heading, path_angle, _ = state
            ground = velocity(state) + WIND
            seen = Measurement(0.0, np.array(place), ground, heading, path_angle, bank=bank(k))
            set_measurement(message, stamp, seen)
        if k in astray:
            message.pose.pose.position.x = -10_837_714.0
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


def test_a_measured_bank_is_read_back_and_changes_nothing_else(tmp_path):
    level = fly(tmp_path / "level.mcap")
    rolled = fly(tmp_path / "rolled.mcap", bank=lambda k: 0.05 * k - 0.3)
    assert level.measured_bank is None
    np.testing.assert_allclose(rolled.measured_bank, 0.05 * np.arange(20) - 0.3, atol=1e-9)
    np.testing.assert_allclose(rolled.vehicle, level.vehicle, atol=1e-7)
    np.testing.assert_allclose(rolled.ground_velocity, level.ground_velocity, atol=1e-7)


def test_a_state_of_no_place_on_this_earth_is_left_out_and_counted(tmp_path):
    log = fly(tmp_path / "flight.mcap", astray={3, 7})
    assert len(log.time) == 18
    numbers = metrics(log)
    assert numbers["unusable_messages"] == 2
    assert "2 messages could not be used" in verdict(numbers)


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


def test_the_folder_is_a_bag_of_ros_2(tmp_path):
    """As ``ros2 bag info FOLDER`` reads it: the file by its name, what was offered, all counts."""
    bag = recorded(tmp_path / "mission.mcap", alone=True)
    about = yaml.safe_load((tmp_path / "metadata.yaml").read_text())[ROSBAG]
    assert about["ros_distro"] == "jazzy"
    assert about["relative_file_paths"] == ["mission.mcap"]
    assert [entry["path"] for entry in about["files"]] == ["mission.mcap"]
    assert (about["version"], about["storage_identifier"]) == (9, "mcap")
    assert about["message_count"] == sum(bag.values())
    topics = {
        entry["topic_metadata"]["name"]: entry for entry in about["topics_with_message_count"]
    }
    assert {name: topics[name]["message_count"] for name in bag} == bag
    offered = {
        name: entry["topic_metadata"]["offered_qos_profiles"] for name, entry in topics.items()
    }
    infinite = {"sec": 9223372036, "nsec": 854775807}
    assert offered["/uav/odometry"] == [
        {
            "history": "keep_last",
            "depth": ODOMETRY.qos.depth,
            "reliability": "reliable",
            "durability": "volatile",
            "deadline": infinite,
            "lifespan": infinite,
            "liveliness": "automatic",
            "liveliness_lease_duration": infinite,
            "avoid_ros_namespace_conventions": False,
        }
    ]
    (rosout,) = offered["/rosout"]
    assert (rosout["durability"], rosout["depth"]) == ("transient_local", 1000)
    assert rosout["lifespan"] == {"sec": 10, "nsec": 0}
    with Reader(tmp_path) as reader:
        heard = [connection.topic for connection, _, _ in reader.messages(reader.connections)]
    assert {name: heard.count(name) for name in bag} == bag


def test_the_file_names_itself_and_its_chunks_are_compressed(tmp_path):
    """As the format's own library reads it."""
    mcap = pytest.importorskip("mcap.reader")
    path = tmp_path / "flight.mcap"
    recorded(path)
    assert not (tmp_path / "metadata.yaml").exists()  # a folder may hold several
    with path.open("rb") as file:
        reader = mcap.make_reader(file)
        summary = reader.get_summary()
        (record,) = reader.iter_metadata()
    about = yaml.safe_load(record.metadata["serialized_metadata"])
    assert about["relative_file_paths"] == ["flight.mcap"]
    assert about["ros_distro"] == "jazzy"
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
    assert {channel.topic for channel in summary.channels.values()} >= {"/tf", "/rosout"}


@pytest.mark.parametrize("frame", ["base_link", "uav1/base_link", "b", "ba", "bas"])
def test_the_bag_holds_the_transform_of_every_state(tmp_path, frame):
    """With the frames of the state, however long their names are."""
    recorded(tmp_path / "flight.mcap", frame)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(tmp_path / "flight.mcap") as reader:
        wanted = [c for c in reader.connections if c.topic == "/tf"]
        found = [
            (time, store.deserialize_cdr(data, "tf2_msgs/msg/TFMessage"))
            for _, time, data in reader.messages(wanted)
        ]
    odometry = ODOMETRY.type()
    for (time, message), (stamp, state) in zip(found, states(), strict=True):
        set_odometry(odometry, stamp, state, np.zeros(3), velocity(state))
        (transform,) = message.transforms
        assert time == stamp + 1
        assert transform.header.stamp.sec * 10**9 + transform.header.stamp.nanosec == stamp
        assert (transform.header.frame_id, transform.child_frame_id) == ("map", frame)
        for part, expected in (
            (transform.transform.translation, odometry.pose.pose.position),
            (transform.transform.rotation, odometry.pose.pose.orientation),
        ):
            for name in expected.get_fields_and_field_types():
                assert getattr(part, name) == getattr(expected, name)


@pytest.mark.parametrize("frame", ["base_link", "uav1/base_link"])
def test_the_bag_holds_the_frames_of_autopilots(tmp_path, frame):
    """Axes of map_ned in map (east, north, up), of the aircraft's _frd in its own; same origins."""
    recorded(tmp_path / "flight.mcap", frame)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(tmp_path / "flight.mcap") as reader:
        wanted = [c for c in reader.connections if c.topic == "/tf_static"]
        ((connection, _, data),) = reader.messages(wanted)
    assert connection.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"
    ned, frd = store.deserialize_cdr(data, connection.msgtype).transforms
    for transform, parent, child, axes in (
        (ned, "map", "map_ned", [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
        (frd, frame, f"{frame}_frd", [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    ):
        assert (transform.header.frame_id, transform.child_frame_id) == (parent, child)
        place = transform.transform.translation
        assert (place.x, place.y, place.z) == (0.0, 0.0, 0.0)
        q = transform.transform.rotation
        turned = Rotation.from_quat([q.x, q.y, q.z, q.w]).apply(np.eye(3))
        np.testing.assert_allclose(turned, axes, atol=1e-15)


def recorded(path, frame="base_link", **options):
    """A bag with the states of above and a line of the log; the number of messages by topic."""
    bag = FlightBag(path, **options)
    for stamp, state in states():
        message = ODOMETRY.type()
        set_odometry(message, stamp, state, np.zeros(3), velocity(state))
        message.child_frame_id = frame
        bag.write(ODOMETRY, stamp + 1, serialize_message(message))
    bag.write(ROSOUT, STEP, serialize_message(ROSOUT.type(msg="said")))
    bag.close()
    return {"/uav/odometry": 20, "/tf": 20, "/tf_static": 1, "/rosout": 1, "/uav/command": 0}


def transforms(path, *states):
    """Messages on ``/tf`` of a bag that was written these states, as bytes."""
    bag = FlightBag(path)
    for k, data in enumerate(states):
        bag.write(ODOMETRY, k, data)
    bag.close()
    with Reader(path) as reader:
        return [topic.topic for topic, _, _ in reader.messages()].count("/tf")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["position", "orientation"])
def test_a_pose_that_is_not_finite_makes_no_transform(tmp_path, part, value):
    message = ODOMETRY.type()
    set_odometry(message, 1, np.array([1.0, 2.0, 3.0, 0.4, 0.1, 20.0]), np.zeros(3), np.zeros(3))
    whole = serialize_message(message)
    getattr(message.pose.pose, part).y = value
    assert transforms(tmp_path / "flight.mcap", serialize_message(message), whole) == 1


def test_bytes_that_are_no_state_make_no_transform(tmp_path):
    data = serialize_message(ODOMETRY.type())
    cut = [data[:length] for length in range(0, len(data), 7)]
    assert transforms(tmp_path / "flight.mcap", *cut, data) == 1
