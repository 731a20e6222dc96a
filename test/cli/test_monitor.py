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

"""The monitor from the command line: in the namespace that was asked for."""

import pytest

from uav_tracking_mpc.cli.main import main

pytest.importorskip("rclpy")


@pytest.mark.parametrize(
    ("words", "namespace"),
    [([], "/"), (["--namespace", "red"], "/red"), (["--namespace", "/fleet/red/"], "/fleet/red")],
)
def test_it_watches_a_namespace(words, namespace, monkeypatch):
    given = []

    def run(name, create, arguments):
        given.extend([name, *arguments])
        return 0

    monkeypatch.setattr("uav_tracking_mpc.nodes.run.run", run)
    assert main(["monitor", *words]) == 0
    assert given == ["monitor", "--ros-args", "-r", f"__ns:={namespace}"]
