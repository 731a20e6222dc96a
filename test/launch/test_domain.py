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

from __future__ import annotations

import pytest

from uav_tracking_mpc.cli.ending import explanation
from uav_tracking_mpc.nodes.ros_environment import DomainValueError, exported_domain


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
