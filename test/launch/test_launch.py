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

"""Launches of real processes."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import socket
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import vehicle_from_odometry
from paced_link import LINK
from processes import (
    DOMAIN,
    INTERRUPT,
    KILL,
    TERMINATE,
    alive,
    ended,
    environment,
    nodes_of,
    outcome,
    run,
    started,
    undecided,
    wait_for,
)
from rosbags.rosbag2 import Reader
from test_commands import AUTOPILOT, commands

from uav_tracking_mpc.cli import launch_tracking
from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.control.record import recorded_parameters, replay
from uav_tracking_mpc.launch.supervisor import LAST_DOMAIN, LaunchError, own_domain
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.mpc.compiled_method import CompilationError
from uav_tracking_mpc.nodes.bag_log import flight_log, messages
from uav_tracking_mpc.nodes.messages.conversions import plan_from_command
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    ORBIT,
    ROSOUT,
)
from uav_tracking_mpc.settings.configuration import load_configuration

pytestmark = pytest.mark.nodes


FLYING = "flying on commands"
NODES = {"uav_simulator", "target_publisher", "nmpc_controller"}


def test_an_exported_domain_is_flown_in_and_an_option_wins():
    """Either is ended before it flies."""
    code, output = run("cli.launch_tracking", stop=INTERRUPT, after="domain")
    assert output.startswith(f"domain {DOMAIN} (from ROS_DOMAIN_ID): watch with")
    assert code == 0
    assert "Traceback" not in output
    with own_domain(None) as other:
        words = ("--domain-id", other)
        _, output = run("cli.launch_tracking", *words, stop=TERMINATE, after="domain")
    assert output.startswith(f"domain {other}: watch with")


def test_a_domain_that_is_not_allowed_is_refused(monkeypatch, capsys):
    monkeypatch.setenv("ROS_DOMAIN_ID", "300")
    assert launch_tracking.main([]) == 2
    assert capsys.readouterr().err == (
        "launch_tracking: environment variable ROS_DOMAIN_ID is '300', must be an integer from 0 "
        "to 232\n"
    )


def test_without_a_home_and_with_an_empty_cache_it_flies_at_once_until_ctrl_c(tmp_path):
    """The signal is passed on, and nothing stays behind."""
    nowhere = tmp_path / "file"
    nowhere.write_text("")
    env = environment() | {
        "HOME": str(nowhere),
        "ROS_LOG_DIR": "",
        "ROS_HOME": "",
        "XDG_CACHE_HOME": str(nowhere),
        "TMPDIR": str(tmp_path),
    }
    with started("cli.launch_tracking", after=FLYING, env=env) as process:
        nodes = nodes_of(process.pid)
        code, output = ended(process, INTERRUPT)
    assert code == 0, output
    assert set(nodes) == NODES
    assert not any(alive(node) for node in nodes.values())
    assert "Traceback" not in output
    assert "/.ros/log cannot be written" in output
    begin, flying = (output.index(words) for words in ("ipopt solves while", FLYING))
    assert begin < flying
    assert "solver compiled" not in output[:flying]


BY_LINK = ("fly", "--config", "small_uav", "--json", "--link")


def test_a_flight_counts_from_when_it_is_engaged_and_tells_of_its_link(tmp_path):
    words = ("ardupilot", "--simulated", "--engage", "--duration", 4, "--output", tmp_path)
    code, output, errors = outcome("cli.main", *BY_LINK, *words)
    assert code == 3, errors  # 4 s are not enough
    assert errors.splitlines()[-1].startswith("not settled in ")
    numbers = json.loads(output)
    assert numbers["duration_s"] == pytest.approx(4.0, abs=1.5)
    assert numbers["speed"] == 1.0
    keys = {"dialect", "rate_hz", "latency_ms", "latency_p99_ms", "lost", "refused"}
    assert numbers["link"].keys() == keys
    assert numbers["link"]["rate_hz"] > 5.0
    assert numbers["solver"]["solves"] > 10
    assert "engaged" in errors
    assert "Traceback" not in errors
    counts = Counter(topic for topic, *_ in messages(tmp_path / "mission.mcap", COMMAND, ORBIT))
    assert counts[ORBIT] > 0.5 * counts[COMMAND] > 5


@pytest.mark.long
def test_the_commands_of_the_tutorial_fly_an_autopilot(tmp_path):
    """With the simulated autopilot, at a port that is free; shorter than it is written."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    check, *flights = (shlex.split(line.replace("14560", port)) for line in commands(AUTOPILOT))
    stand_in = f"udpout:127.0.0.1:{port}"
    with started("cli.main", "autopilot", "--dialect", "ardupilot", "--connection", stand_in):
        code, output, errors = outcome("cli.main", *check[1:])
        assert code == 0, errors
        assert "ArduPlane" in output
        for words in flights:
            words[words.index("--duration") + 1] = "4"
            words[words.index("--output") + 1] = str(tmp_path)
            code, _, errors = outcome("cli.main", *words[1:])
            assert code == 3, errors  # 4 s are not enough
            assert "engaged" in errors
            assert (tmp_path / "report.html").is_file()


@pytest.mark.parametrize("failure", [None, CompilationError("no room"), NotImplementedError("erf")])
def test_an_autopilot_is_flown_by_a_solver_that_is_compiled(tmp_path, capsys, monkeypatch, failure):
    """Before a node starts; where that cannot be, another solver flies."""
    done = []

    def compile_flight(tracking):
        done.append(tracking.solver)
        if failure:
            raise failure

    def launch(*_, **__):
        done.append("launched")
        raise LinkError("enough")

    monkeypatch.setattr("uav_tracking_mpc.mpc.machine_code.finished", lambda folder: False)
    monkeypatch.setattr("uav_tracking_mpc.control.guidance.compile_flight", compile_flight)
    monkeypatch.setattr("uav_tracking_mpc.launch.flight.launch", launch)
    assert main([*BY_LINK, LINK, "--output", str(tmp_path)]) == 2
    assert done == ["newton", "launched"]
    assert "compiling the solver" in (errors := capsys.readouterr().err)
    assert (str(failure) in errors) is (failure is not None)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((LINK, "--connection", "tight"), "needs a turn rate"),
        (("ardupilot", "--connection", "udpin:nowhere"), "must be udpin:HOST:PORT"),
    ],
)
def test_what_cannot_be_flown_starts_nothing(tmp_path, capsys, arguments, words):
    assert main([*BY_LINK, *arguments, "--output", str(tmp_path)]) == 2
    output, errors = capsys.readouterr()
    assert output == ""
    assert words in errors.splitlines()[-1]
    assert "domain" not in errors
    assert not list(tmp_path.iterdir())


def test_without_engage_nothing_is_commanded_and_it_says_how(tmp_path):
    """By a link of one's own."""
    env = environment() | {"PYTHONPATH": str(Path(__file__).parents[1])}
    how = {"after": "tracking: optimal plan", "env": env, "apart": True}
    with started("cli.main", *BY_LINK, LINK, "--output", tmp_path, **how) as process:
        process.send_signal(INTERRUPT)
        output, rest = process.communicate(timeout=900)
    assert process.returncode == 130
    assert "until somebody engages: `uav_tracking engage --domain-id" in process.said
    assert "interrupted before the autopilot was engaged" in rest
    assert output == ""
    assert not (tmp_path / "mission.mcap").exists()


def shared_memory(process):
    """Files of Fast DDS in shared memory that a process maps."""
    with contextlib.suppress(OSError):
        lines = Path(f"/proc/{process}/maps").read_text(errors="replace").splitlines()
        return [line.split()[-1] for line in lines if "/dev/shm/fastrtps" in line]
    return []


def test_a_node_that_dies_ends_launch_tracking_with_code_1(monkeypatch, capsys):
    """The rest shows test_a_flight_whose_node_died_is_kept_and_reported."""

    def launch(*_, **__):
        raise LaunchError("uav_simulator died with exit code -9")

    monkeypatch.setattr("uav_tracking_mpc.launch.flight.launch", launch)
    assert launch_tracking.main([]) == 1
    assert "uav_simulator died with exit code -9" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells children of the death")
def test_nodes_do_not_outlive_a_killed_launcher():
    words, after = ("--config", "paper"), FLYING
    with started("cli.launch_tracking", *words, after=after, env=undecided()) as process:
        nodes = nodes_of(process.pid)
        assert set(nodes) == NODES
        # A process that is killed would leave them as they were at that moment.
        assert not any(map(shared_memory, [process.pid, *nodes.values()]))
        process.kill()
        assert wait_for(lambda: not any(alive(node) for node in nodes.values()))


def test_two_launches_get_two_domains():
    with own_domain(None) as first, own_domain(None) as second:
        assert first != second
        assert 1 <= min(first, second) <= max(first, second) <= LAST_DOMAIN
    with own_domain(7) as asked:
        assert asked == 7


def test_a_flight_that_is_interrupted_before_it_begins_leaves_nothing(tmp_path):
    flight = ("fly", "--duration", 600, "--output", tmp_path)
    with started("cli.main", *flight, after="domain", apart=True) as process:
        process.send_signal(INTERRUPT)
        output, errors = process.communicate(timeout=900)
    assert (process.returncode, output) == (130, "")
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert not list(tmp_path.iterdir())


def test_a_flight_whose_node_died_is_kept_and_reported(tmp_path):
    flight = ("fly", "--duration", 600, "--output", tmp_path)
    with started("cli.main", *flight, after=FLYING, apart=True) as process:
        nodes = nodes_of(process.pid)
        os.kill(nodes["nmpc_controller"], KILL)
        output, errors = process.communicate(timeout=900)
    assert process.returncode == 1, errors
    assert not any(alive(node) for node in nodes.values())
    assert "nmpc_controller died with exit code -9" in errors
    assert "of 600 s were flown" in errors
    assert "Traceback" not in errors
    assert str(tmp_path / "report.html") in output
    log = flight_log(tmp_path / "mission.mcap", load_configuration("paper"))
    assert 0.0 < log.duration < 600.0
    assert recorded_parameters(tmp_path / "controller.jsonl").orbit == log.orbit
    assert not list(tmp_path.glob(".*"))


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A mission with real processes through the command, as a user runs it, from near the orbit."""
    output = tmp_path_factory.mktemp("flight")
    near = ("initial_position=[155.0, 0.0, 48.0]", "initial_heading=-1.57", "initial_speed=4.0")
    start = [word for each in near for word in ("--set", f"uav_simulator.{each}")]
    # On a loaded machine, where late commands cost range at the speed of the demo.
    patient = ("--set", "nmpc_controller.solve_time_max=1.0", "--speed", 3)
    words = ("fly", "--duration", 25, "--output", output, "--json", *start, *patient)
    code, told, errors = outcome("cli.main", *words, env=undecided())
    assert code == 0, errors
    return output, json.loads(told)


def test_the_mission_is_flown_recorded_and_reported(flight):
    output, metrics = flight
    files = {
        "metrics.json", "trajectory.png", "states.png", "report.html", "mission.mcap",
        "metadata.yaml", "controller.jsonl",
    }  # fmt: skip
    assert {path.name for path in output.iterdir()} == files
    assert json.loads((output / "metrics.json").read_text()) == metrics
    assert metrics["settling_s"]["altitude"] <= 10.0
    assert metrics["settling_s"]["range"] <= 12.0
    assert metrics["steady_state"]["range_rms_m"] <= 0.05
    assert metrics["steady_state"]["altitude_rms_m"] <= 0.05
    assert metrics["solver"]["failures"] == 0
    assert metrics["commands"]["sent"] >= metrics["solver"]["solves"] > 50
    assert metrics["latency_us"]["median"] > 0.0


def test_what_was_flown_is_flown_again_bit_for_bit(flight):
    """By the controller alone, until a solve met its time budget."""
    output, metrics = flight
    steps = list(replay(output / "controller.jsonl"))
    commands = [step.recorded for step in steps if step.recorded is not None]
    assert len(commands) >= metrics["commands"]["sent"]  # some after the mission's end
    late = [step.recorded is not None and step.recorded.out_of_time for step in steps]
    repeatable = late.index(True) if any(late) else len(steps)
    assert all(step.same for step in steps[:repeatable])


def _stamp(message):
    return message.header.stamp.sec, message.header.stamp.nanosec


def test_the_bag_holds_every_topic_and_reads_back_equal(flight):
    output, _ = flight
    topics, times, _ = zip(*messages(output / "mission.mcap", *ALL), strict=True)
    counts = Counter(topic.name for topic in topics)
    assert all(counts[topic.name] for topic in ALL if not topic.optional), counts
    assert list(times) == sorted(times)
    with Reader(output) as reader:  # the folder, by its metadata
        told = {connection.topic: connection.msgcount for connection in reader.connections}
    assert told["/tf"] == told["/uav/odometry"] == counts["uav/odometry"]
    said = {message.name for _, _, message in messages(output / "mission.mcap", ROSOUT)}
    assert "nmpc_controller" in said
    log = flight_log(output / "mission.mcap", load_configuration("paper"))
    flown = [message for _, _, message in messages(output / "mission.mcap", ODOMETRY)]
    flown = flown[-len(log.vehicle) :]
    states = np.array([vehicle_from_odometry(message) for message in flown])
    np.testing.assert_allclose(log.vehicle[:, :5], states[:, :5], atol=1e-9)
    # The airspeed comes by itself, and may get lost on a busy machine: then the last one stays. In
    # still air it is the ground speed, but for its rounding.
    air = messages(output / "mission.mcap", AIR_VELOCITY)
    measured = {_stamp(message) for _, _, message in air}
    whole = np.array([_stamp(message) in measured for message in flown])
    assert np.mean(whole) > 0.9
    np.testing.assert_allclose(log.vehicle[whole], states[whole], atol=1e-9)
    first = next(messages(output / "mission.mcap", COMMAND))[2]
    np.testing.assert_array_equal(plan_from_command(first)[0][0], log.inputs[0])
    levels = {
        status.level
        for _, _, message in messages(output / "mission.mcap", DIAGNOSTICS)
        for status in message.status
    }
    assert int.from_bytes(DiagnosticStatus.OK, "little") in levels
