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

"""``uav_tracking view FILE``: what cannot be shown is told in one line."""

import pytest
from recorded_bag import write_bag

from uav_tracking_mpc.nodes.topics import TARGET


@pytest.fixture
def bag(tmp_path):
    """Without an aircraft."""
    path = tmp_path / "flight.mcap"
    write_bag(path, 1.0, state_rate=20, command_rate=10, topics=(TARGET,))
    return path


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data, "holds no aircraft"),
        (lambda data: data[:-100], "is cut off"),
        (lambda data: b"", "is empty"),
        (lambda data: b"#" * 100, "is no bag"),
    ],
)
def test_a_file_that_holds_no_flight(bag, uav_tracking, change, words):
    bag.write_bytes(change(bag.read_bytes()))
    said = uav_tracking.refused("view", bag)
    assert said.count("\n") == 1
    assert str(bag) in said
    assert words in said


def test_a_file_that_is_not_there(tmp_path, uav_tracking):
    said = uav_tracking.refused("view", tmp_path / "none.mcap", code=1)
    assert said.count("\n") == 1
    assert "there is no bag" in said and "none.mcap" in said


def test_overrides_need_a_configuration(bag, uav_tracking):
    refusal = uav_tracking.refused("view", bag, "--set", "nmpc_controller.range=300.0")
    assert "needs --config" in refusal
