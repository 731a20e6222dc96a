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

from dataclasses import replace

import numpy as np
import pytest
import yaml
from filled_messages import (
    filled_air,
    filled_command,
    filled_measurement,
    filled_odometry,
    filled_point,
    filled_status,
    write_messages,
)
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.bag_log import flight_log, through_the_air
from uav_tracking_mpc.nodes.flight_recorder import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    ROSOUT,
    TARGET,
    FrameNames,
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


TARGET_RUNS = ("target_publisher.motion=line", "target_publisher.speed=2.0")


def fly(path, air=lambda k: True, bank=None, astray=()):
    """The flight by simulated time, in wind."""

    def said():
        for k, (stamp, state) in enumerate(states()):
            ground = velocity(state) + WIND
            seen = Measurement(0.0, state[:3], ground, state[3], state[4], bank=bank and bank(k))
            odometry = filled_measurement(stamp, seen)
            if k in astray:
                odometry.pose.pose.position.x = -10_837_714.0
            yield ODOMETRY, stamp + 1, odometry
            if air(k):
                yield AIR_VELOCITY, stamp + 2, filled_air(stamp, state[5])
            if k == 0:
                yield COMMAND, stamp + 3, filled_command(stamp, np.zeros((2, 3)))

    return flight_log(write_messages(path, said()), load_configuration("paper", TARGET_RUNS))


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


def test_a_measured_bank_is_read_back(tmp_path):
    level = fly(tmp_path / "level.mcap")
    rolled = fly(tmp_path / "rolled.mcap", bank=lambda k: 0.05 * k - 0.3)
    assert level.measured_bank is None
    np.testing.assert_allclose(rolled.measured_bank, 0.05 * np.arange(20) - 0.3, atol=1e-9)
    places = slice(0, 3)
    np.testing.assert_allclose(rolled.vehicle[:, places], level.vehicle[:, places], atol=1e-7)


def test_the_angle_of_attack_of_a_body_is_no_wind():
    """Level and straight in still air, its nose 3 deg up and its wings nearly level."""
    body = Measurement(0.0, np.zeros(3), [22.0, 0.0, 0.0], 0.0, 0.05, bank=1e-3)
    told = [(k * STEP, replace(body, stamp=0.05 * k)) for k in range(20)]
    for _, seen in through_the_air(told, [(0, 22.0)]):
        assert abs(seen.path_angle) < 1e-9
        assert abs(seen.heading) < 1e-3


def test_a_state_of_no_place_on_this_earth_is_left_out_and_counted(tmp_path):
    log = fly(tmp_path / "flight.mcap", astray={3, 7})
    assert len(log.time) == 18
    numbers = metrics(log)
    assert numbers["unusable_messages"] == 2
    assert "2 messages could not be used" in verdict(numbers)


def test_a_bag_without_a_state_of_the_flight_is_refused_in_words(tmp_path):
    with pytest.raises(ValueError, match="holds no state of the aircraft"):
        fly(tmp_path / "flight.mcap", astray=range(20))


def fly_with_link(path, engaged=True, target_system=0):
    """The flight of above by wall time, engaged at its fifth state; the target began before it."""

    def said():
        for k, (stamp, state) in enumerate(states()):
            stamp += WALL
            odometry = filled_odometry(stamp, state, ground=velocity(state))
            yield ODOMETRY, stamp + 1, odometry
            yield COMMAND, stamp + 1, filled_command(stamp, np.zeros((2, 3)))
            yield TARGET, stamp + 1, filled_point(stamp, [0.1 * k, 0.0, 0.0])
            yield ENGAGED, stamp - 1, ENGAGED.type(data=engaged and k >= 5)
        values = {
            "dialect": "ardupilot", "rate [Hz]": 50.0, "latency median [ms]": 2.5,
            "messages lost": 3, "commands refused": 1, "plans refused": 2,
        }  # fmt: skip
        yield DIAGNOSTICS, WALL + 1, filled_status(0, "autopilot_link", values=values)
        began = {"began [ns]": WALL - 10 * STEP}
        yield DIAGNOSTICS, WALL + 1, filled_status(0, "target_publisher", values=began)

    link = ("autopilot_link.link=ardupilot", f"autopilot_link.target_system={target_system}")
    configuration = load_configuration("paper", [*TARGET_RUNS, *link])
    return flight_log(write_messages(path, said()), configuration)


def test_with_a_link_a_flight_begins_when_engaged_and_the_target_when_its_node_did(tmp_path):
    log = fly_with_link(tmp_path / "flight.mcap")
    np.testing.assert_allclose(log.time, STEP * 1e-9 * np.arange(15), atol=1e-6)
    np.testing.assert_allclose(log.command_time, log.time)
    assert log.vehicle[0, 0] == 195.0
    assert log.plant == "ardupilot"
    assert log.link.dialect == "ardupilot"
    assert (log.link.rate, log.link.latency, log.link.lost, log.link.refused) == (50.0, 2.5, 3, 3)
    assert np.isnan(log.link.latency_p99)
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


@pytest.mark.parametrize("frame", ["base_link", "uav1/base_link"])
def test_the_bag_holds_the_frames_of_aircraft_and_autopilots(tmp_path, frame):
    """Axes of map_ned in map (east, north, up), of the aircraft's _frd in its own; same origins."""
    recorded(tmp_path / "flight.mcap", frame)
    found = read(tmp_path / "flight.mcap", "/tf")
    for (_, time, message), (stamp, state) in zip(found, states(), strict=True):
        pose = state_message(stamp, state).pose.pose
        (transform,) = message.transforms
        assert time == stamp + 1
        assert nanoseconds(transform.header.stamp) == stamp
        assert (transform.header.frame_id, transform.child_frame_id) == ("map", frame)
        for part, expected in (
            (transform.transform.translation, pose.position),
            (transform.transform.rotation, pose.orientation),
        ):
            for name in expected.get_fields_and_field_types():
                assert getattr(part, name) == getattr(expected, name)
    ((connection, _, message),) = read(tmp_path / "flight.mcap", "/tf_static")
    assert connection.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"
    ned, frd = message.transforms
    for transform, parent, child, axes in (
        (ned, "map", "map_ned", [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
        (frd, frame, f"{frame}_frd", [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    ):
        assert (transform.header.frame_id, transform.child_frame_id) == (parent, child)
        place, q = transform.transform.translation, transform.transform.rotation
        assert (place.x, place.y, place.z) == (0.0, 0.0, 0.0)
        turned = Rotation.from_quat([q.x, q.y, q.z, q.w]).apply(np.eye(3))
        np.testing.assert_allclose(turned, axes, atol=1e-15)


def state_message(stamp, state, frame="base_link"):
    frames = FrameNames("map", frame)
    return filled_odometry(stamp, state, ground=velocity(state), frames=frames)


def recorded(path, frame="base_link", **options):
    """A bag with the states of above and a line of the log; the number of messages by topic."""
    flown = [(ODOMETRY, stamp + 1, state_message(stamp, x, frame)) for stamp, x in states()]
    write_messages(path, [*flown, (ROSOUT, STEP, ROSOUT.type(msg="said"))], **options)
    return {"/uav/odometry": 20, "/tf": 20, "/tf_static": 1, "/rosout": 1, "/uav/command": 0}


def read(path, topic):
    """Connection, time and message of all that a bag holds of a topic."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(path) as reader:
        return [
            (connection, time, store.deserialize_cdr(data, connection.msgtype))
            for connection, time, data in reader.messages()
            if connection.topic == topic
        ]


def transforms(path, *states):
    """How many messages on ``/tf`` a bag has that was written these states, as bytes."""
    bag = FlightBag(path)
    for k, data in enumerate(states):
        bag.write(ODOMETRY, k, data)
    bag.close()
    return len(read(path, "/tf"))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["position", "orientation"])
def test_a_pose_that_is_not_finite_makes_no_transform(tmp_path, part, value):
    message = filled_odometry(1, [1.0, 2.0, 3.0, 0.4, 0.1, 20.0])
    whole = serialize_message(message)
    getattr(message.pose.pose, part).y = value
    assert transforms(tmp_path / "flight.mcap", serialize_message(message), whole) == 1


def test_bytes_that_are_no_state_make_no_transform(tmp_path):
    data = serialize_message(ODOMETRY.type())
    cut = [data[:length] for length in range(0, len(data), 7)]
    assert transforms(tmp_path / "flight.mcap", *cut, data) == 1
