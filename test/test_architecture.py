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

"""The layout is the table of contents: imports point down, and ROS stops at the nodes."""

import ast
import functools
import subprocess
import sys
from collections import defaultdict
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "uav_tracking_mpc"
LAYERS = (
    "parameters",
    "symbolic",
    "dynamics",
    "mpc",
    "limits",
    "settings",
    "estimation",
    "laws",
    "terminal",
    "formulation",
    "control",
    "margins",
    "simulation",
    "report",
    "links",
    "autopilot",
    "nodes",
    "launch",
    "view",
    "studies",
    "cli",
    "__main__",
)
ROS = {
    "rclpy", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "lifecycle_msgs", "nav_msgs",
    "rcl_interfaces", "rosgraph_msgs", "sensor_msgs", "std_msgs", "std_srvs", "tf2_msgs",
    "trajectory_msgs", "visualization_msgs",
}  # fmt: skip
LINE_LIMIT = 500
SOURCES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")
ROOMS = sorted(path for path in PACKAGE.rglob("__init__.py") if path.parent != PACKAGE)


def name(path):
    return str(path.relative_to(PACKAGE))


def layer(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@functools.cache
def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path, nodes=None):
    for node in ast.walk(tree(path)) if nodes is None else nodes:
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def module(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def upwards(path):
    """Imports of a file that point up, and those of ROS where there is none."""
    own = LAYERS.index(layer(path))
    for imported in imports(path):
        parts = imported.split(".")
        ours = parts[0] == "uav_tracking_mpc" and len(parts) > 1 and parts[1] in LAYERS
        if ours and LAYERS.index(parts[1]) > own:
            yield f"{name(path)} imports {imported}"
        if parts[0] in ROS and layer(path) not in ("nodes", "launch", "studies"):
            yield f"{name(path)} imports {imported}"


def test_imports_point_down():
    assert [each for path in SOURCES for each in upwards(path)] == []


def test_no_circular_imports():
    """Among the imports that run when a module is loaded."""
    modules = {module(path): path for path in SOURCES}
    graph = {
        importer: {
            imported
            for imported in imports(path, tree(path).body)
            if imported in modules and imported != importer
        }
        for importer, path in modules.items()
    }
    list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the cycle


def test_everything_below_the_nodes_runs_without_ros():
    """Even the command line: only flying needs rclpy."""
    program = (
        "import sys; sys.modules['rclpy'] = None; import uav_tracking_mpc.cli.main as cli; "
        "sys.exit(cli.main(['--version']))"
    )
    finished = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr


@pytest.mark.parametrize("room", ROOMS, ids=name)
def test_a_room_lists_its_files(room):
    """The docstring of a room names each of its files and rooms."""
    words = ast.get_docstring(tree(room)) or ""
    files = [file for file in room.parent.glob("*.py") if not file.name.startswith("_")]
    files += [inner.parent for inner in room.parent.glob("*/__init__.py")]
    missing = [file.stem for file in files if f"``{file.stem}``" not in words]
    assert not missing, f"not in the docstring of {room}: {', '.join(missing)}"


def length(path):
    """Lines; a licence in front of everything does not count."""
    lines = path.read_text(encoding="utf-8").splitlines()
    begin = next((k for k, line in enumerate(lines) if line and not line.startswith("#")), 0)
    return len(lines) - begin


def test_no_file_is_long():
    assert [name(path) for path in SOURCES if length(path) > LINE_LIMIT] == []


def test_a_files_name_is_its_own():
    """But for shared parts, commands named after what they run, and what people find by name."""
    rooms = [room for room in ROOMS if "= ExtensionPoint(" in room.read_text(encoding="utf-8")]
    extensions = {room.parent.relative_to(PACKAGE) for room in rooms}
    places = defaultdict(list)
    for path in SOURCES:
        folder = path.relative_to(PACKAGE).parent
        if path.name[0] != "_" and folder not in extensions and folder != Path("cli"):
            places[path.stem].append(name(path))
    doubles = {stem: found for stem, found in places.items() if len(found) > 1}
    assert not doubles, doubles
