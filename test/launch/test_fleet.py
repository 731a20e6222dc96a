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

"""What the files for ROS 2's own tools name exists: topics, frames, groups for every aircraft."""

import json
import re
from pathlib import Path

import pytest
import yaml

from uav_tracking_mpc.launch.fleet import absolute, recorded_topics, rviz_view
from uav_tracking_mpc.nodes.topics import ALL, FRAMES, MARKERS, ODOMETRY, PREDICTED_PATH, TARGET

ROOT = Path(__file__).parents[2]
TEMPLATE = (ROOT / "rviz" / "tracking.rviz").read_text()
LAYOUT = json.loads((ROOT / "foxglove" / "tracking.json").read_text())
TOPICS = {absolute("", topic.name): topic for topic in ALL}
PATH = re.compile(r"(?P<topic>/[\w/]+)(?P<fields>(\.\w+(\[\d+\])?)*)")


def shown(view):
    """Topic and display class of everything that RViz subscribes to."""

    def displays(group):
        for display in group["Displays"]:
            yield display
            if "Displays" in display:
                yield from displays(display)

    return {
        display["Topic"]["Value"]: display
        for display in displays(yaml.safe_load(view)["Visualization Manager"])
        if "Topic" in display
    }


def test_rviz_shows_the_topics_of_an_aircraft_by_their_types():
    found = shown(TEMPLATE)
    assert set(found) == {f"/{topic.name}" for topic in (ODOMETRY, PREDICTED_PATH, MARKERS, TARGET)}
    for name, display in found.items():
        kind = TOPICS[name].type_name.rpartition("/")[2]
        assert display["Class"] == f"rviz_default_plugins/{kind}"
    manager = yaml.safe_load(TEMPLATE)["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == FRAMES.map
    assert "rviz_default_plugins/TF" in {display["Class"] for display in manager["Displays"]}


def test_a_namespace_moves_all_topics_of_a_view():
    found = shown(rviz_view(TEMPLATE, ["a/uav1", "a/uav2"]))
    assert set(found) == {f"/a/uav{k}{name}" for k in (1, 2) for name in shown(TEMPLATE)}
    assert set(shown(rviz_view(TEMPLATE, [""]))) == set(shown(TEMPLATE))


@pytest.mark.parametrize(
    ("space", "name", "expected"),
    [
        ("", "uav/odometry", "/uav/odometry"),
        ("uav1", "uav/odometry", "/uav1/uav/odometry"),
        ("/a/uav1", "uav/odometry", "/a/uav1/uav/odometry"),
        ("uav1", "/diagnostics", "/diagnostics"),
    ],
)
def test_names_are_those_that_ros_makes(space, name, expected):
    assert absolute(space, name) == expected


def test_what_ros_fixes_is_recorded_once():
    names = recorded_topics(["uav1", "uav2"])
    assert names.count("/diagnostics") == names.count("/clock") == names.count("/tf") == 1
    assert sum(name.endswith("/uav/odometry") for name in names) == 2


def panels(kind):
    return [panel for name, panel in LAYOUT["configById"].items() if name.startswith(f"{kind}!")]


def message_paths():
    for plot in panels("Plot"):
        yield from (line["value"] for line in plot["paths"])
    for panel in panels("RawMessages"):
        yield panel["topicPath"]
    for panel in (*panels("DiagnosticSummary"), *panels("RosOut")):
        yield panel["topicToRender"]
    for panel in panels("3D"):
        yield from panel["topics"]


@pytest.mark.parametrize("path", sorted(set(message_paths())))
def test_every_path_of_the_layout_leads_to_a_field(path):
    found = PATH.fullmatch(path)
    message = TOPICS[found["topic"]].type()
    for field, index in re.findall(r"\.(\w+)(\[\d+\])?", found["fields"]):
        kind = message.get_fields_and_field_types()[field]
        message = getattr(message, field)
        if index:
            element = re.fullmatch(r"sequence<(\w+)/(\w+)>", kind)
            package = __import__(f"{element[1]}.msg", fromlist=[element[2]])
            message = getattr(package, element[2])()


def test_the_layout_shows_every_panel_that_it_describes():
    def leaves(part):
        if isinstance(part, str):
            yield part
        else:
            for side in ("first", "second"):
                yield from leaves(part[side])

    assert sorted(leaves(LAYOUT["layout"])) == sorted(LAYOUT["configById"])
    (view,) = panels("3D")
    assert view["followTf"] == FRAMES.map
