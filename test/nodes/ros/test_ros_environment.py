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

"""What ROS finds in the environment: a log folder, a domain, how far it goes."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

import pytest

from uav_tracking_mpc.cli.program import explanation
from uav_tracking_mpc.nodes.ros import ros_environment
from uav_tracking_mpc.nodes.ros.ros_environment import (
    DomainValueError,
    exported_domain,
    stay_on_this_machine,
)


@pytest.fixture
def home(monkeypatch, tmp_path):
    """Home of the user; nothing is exported."""
    temp = tmp_path / "temp"
    temp.mkdir()
    monkeypatch.setattr(ros_environment.tempfile, "gettempdir", lambda: str(temp))
    for variable in ("ROS_LOG_DIR", "ROS_HOME"):
        monkeypatch.setenv(variable, "")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    # Where threads of earlier tests keep machine code, which would make the home.
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "home"


def test_a_writable_home_is_left_to_rcl(home):
    home.mkdir()
    assert ros_environment.ensure_log_folder() == ""
    assert not os.environ["ROS_LOG_DIR"]
    assert (home / ".ros" / "log").is_dir()


def test_without_a_writable_home_logs_go_under_temp_and_that_is_said(home):
    home.write_text("")
    words = ros_environment.ensure_log_folder()
    used = Path(os.environ["ROS_LOG_DIR"])
    assert used.is_dir()
    assert used.parent == home.parent / "temp"
    assert words == f"log folder {home}/.ros/log cannot be written, {used} is used instead"
    assert ros_environment.ensure_log_folder() == ""  # in the processes that inherit it


def test_without_a_home_logs_go_under_temp(home, monkeypatch):
    """Where rcl knows none, though Python finds one."""
    monkeypatch.delenv("HOME")
    assert "log folder ~/.ros/log cannot be written" in ros_environment.ensure_log_folder()
    assert Path(os.environ["ROS_LOG_DIR"]).parent == home.parent / "temp"


@pytest.mark.parametrize(("variable", "below"), [("ROS_LOG_DIR", "."), ("ROS_HOME", "log")])
def test_what_is_exported_is_respected(home, monkeypatch, variable, below):
    home.write_text("")
    wanted = home.parent / "mine"
    monkeypatch.setenv(variable, str(wanted))
    assert ros_environment.ensure_log_folder() == ""
    assert (wanted / below).is_dir()
    assert os.environ[variable] == str(wanted)


@pytest.fixture
def reach(monkeypatch):
    """Exports these variables and no others that say how far ROS goes; returns what then holds."""
    names = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE")

    def exported(**values):
        for name in (*names, "RMW_IMPLEMENTATION"):
            monkeypatch.setenv(name, "")  # put back at the end, whatever the product does
            monkeypatch.delenv(name)
        for name, value in values.items():
            monkeypatch.setenv(name, value)
        stay_on_this_machine()
        return tuple(os.environ.get(name) for name in names)

    return exported


def test_ros_stays_on_this_machine_without_shared_memory(reach):
    how_far, profile = reach()
    assert how_far == "SYSTEM_DEFAULT"  # as the profile says
    transports = ElementTree.parse(profile).getroot()
    space = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"
    assert [each.text for each in transports.iter(f"{space}type")] == ["UDPv4"]
    assert {each.text for each in transports.iter(f"{space}address")} == {"127.0.0.1"}


@pytest.mark.parametrize(
    ("values", "then"),
    [
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, ("SUBNET", None)),
        ({"FASTRTPS_DEFAULT_PROFILES_FILE": "mine.xml"}, ("LOCALHOST", "mine.xml")),
        ({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, ("LOCALHOST", None)),
        ({"RMW_IMPLEMENTATION": "rmw_fastrtps_dynamic_cpp"}, None),
    ],
)
def test_how_far_ros_goes_is_the_users_choice(reach, values, then):
    assert reach(**values) == (then or reach())


@pytest.mark.parametrize(("text", "domain"), [("", None), ("0", 0), (" 42 ", 42), ("232", 232)])
def test_the_exported_domain_is_taken(monkeypatch, text, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    assert exported_domain() == domain


def test_without_one_there_is_none(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert exported_domain() is None


@pytest.mark.parametrize("text", ["233", "-1", "seven", "1.5", "²"])
def test_what_is_not_allowed_is_refused_with_the_range(monkeypatch, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(DomainValueError) as refused:
        exported_domain()
    words = f"environment variable ROS_DOMAIN_ID is {text!r}, must be an integer from 0 to 232"
    assert explanation(refused.value) == (2, words)
