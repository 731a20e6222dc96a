"""The layout is the table of contents: imports point down, and ROS stops at the nodes."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "uav_tracking_mpc"
LAYERS = (
    "parameters",
    "dynamics",
    "mpc",
    "limits",
    "settings",
    "estimation",
    "laws",
    "terminal",
    "formulation",
    "control",
    "simulation",
    "report",
    "links",
    "nodes",
    "launch",
    "view",
    "studies",
    "cli",
    "__main__",
)
ROS = {"rclpy", "builtin_interfaces", "nav_msgs", "geometry_msgs", "trajectory_msgs", "rosbags"}
SOURCES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def layer(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path):
    own = LAYERS.index(layer(path))
    for module in imports(path):
        parts = module.split(".")
        if parts[0] == "uav_tracking_mpc" and len(parts) > 1:
            assert LAYERS.index(parts[1]) <= own, f"{path} imports {module}"
        if parts[0] in ROS:
            assert layer(path) in ("nodes", "launch", "studies"), f"{path} imports {module}"


def test_everything_below_the_nodes_runs_without_ros():
    """Even the command line: only flying needs rclpy."""
    program = (
        "import sys; sys.modules['rclpy'] = None; import uav_tracking_mpc.cli.main as cli; "
        "sys.exit(cli.main(['--version']))"
    )
    finished = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr


def test_every_room_lists_its_files():
    """The docstring of a room names each of its files."""
    for room in PACKAGE.glob("*/__init__.py"):
        words = ast.get_docstring(ast.parse(room.read_text(encoding="utf-8"))) or ""
        for file in room.parent.glob("*.py"):
            if not file.name.startswith("_"):
                assert f"``{file.stem}``" in words, f"{file} is not in the docstring of its room"
