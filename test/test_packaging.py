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

"""The package builds with colcon, installs with pip, and finds its configurations both ways."""

import ast
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import xml.etree.ElementTree as ElementTree

import pytest
from extras import EXTRAS
from sources import ROOT, copied

from uav_tracking_mpc import __version__

PACKAGE = ElementTree.parse(ROOT / "package.xml").getroot()
KEYS = {element.text for element in PACKAGE if element.tag.endswith("_depend")}
BUILT = ("build", "build_links", "install", "install_links", "log", "uav_tracking_mpc.egg-info")
EXECUTABLES = {
    "uav_simulator",
    "target_publisher",
    "nmpc_controller",
    "monitor",
    "launch_tracking",
    "uav_tracking",
}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A clean copy of the sources, as a clone has them."""
    return copied(tmp_path_factory.mktemp("checkout") / "uav_tracking_mpc")


def run(*arguments, cwd, **environment):
    finished = subprocess.run(
        [str(argument) for argument in arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
    )
    assert finished.returncode == 0, finished.stdout + finished.stderr
    return finished.stdout


def colcon():
    """The program: beside this interpreter, or on the path where ROS is installed."""
    folders = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
    return shutil.which("colcon", path=folders) or pytest.skip("colcon is not installed")


def test_colcon_builds_an_ament_python_package(checkout):
    assert "(ros.ament_python)" in run(colcon(), "list", cwd=checkout)
    run(colcon(), "build", "--event-handlers", "console_direct+", cwd=checkout)
    installed = checkout / "install" / "uav_tracking_mpc"
    assert_complete(installed)
    (library,) = installed.glob("lib/python*/site-packages")
    program = "from uav_tracking_mpc.settings.configuration import load_configuration as load;"
    program += "import uav_tracking_mpc; print(uav_tracking_mpc.__file__, load('paper').name)"
    printed = run(sys.executable, "-c", program, cwd=checkout.parent, PYTHONPATH=str(library))
    assert str(library) in printed
    assert printed.split()[-1] == "paper"
    assert_whole(library, checkout)
    # What `ros2 run` starts: the executable itself.
    node = subprocess.run(
        [installed / "lib/uav_tracking_mpc/nmpc_controller", "--ros-args", "-p", "range:=far"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(library)},
    )
    assert node.returncode == 2
    assert "[FATAL] [nmpc_controller]: parameter 'range' is 'far'" in node.stderr


def assert_whole(library, checkout):
    """Every module and template of the sources is there."""
    for source in (checkout / "uav_tracking_mpc").rglob("*"):
        if source.suffix in (".py", ".j2", ".js", ".css", ".typed"):
            assert (library / source.relative_to(checkout)).is_file(), source


@pytest.mark.long
def test_colcon_builds_with_links(checkout):
    """setup.py is then a link in build/, and what it reads is not beside it."""
    bases = ["--build-base", "build_links", "--install-base", "install_links"]
    run(colcon(), "build", "--symlink-install", *bases, cwd=checkout)
    assert_complete(checkout / "install_links" / "uav_tracking_mpc")


def assert_complete(installed):
    names = {path.name for path in (installed / "lib" / "uav_tracking_mpc").iterdir()}
    assert names >= EXECUTABLES
    share = installed / "share"
    assert (share / "ament_index/resource_index/packages/uav_tracking_mpc").is_file()
    assert (share / "uav_tracking_mpc" / "package.xml").is_file()
    assert (share / "uav_tracking_mpc" / "config" / "paper.yaml").is_file()
    assert (share / "uav_tracking_mpc/config/security/uav_tracking.policy.xml").is_file()
    for name in ("launch", "rviz", "foxglove"):
        shipped = {path.name for path in (ROOT / name).iterdir() if path.is_file()}
        assert shipped
        assert {path.name for path in (share / "uav_tracking_mpc" / name).iterdir()} == shipped


def test_pip_installs_commands_marker_and_configurations(checkout, tmp_path):
    """Into a folder of its own, beside the dependencies of this environment."""
    run(
        sys.executable, "-m", "pip", "install", "--quiet", "--no-deps",
        "--no-compile", "--ignore-installed", "--prefix", tmp_path / "env", checkout, cwd=tmp_path,
    )  # fmt: skip
    scripts = {path.name for path in (tmp_path / "env" / "bin").iterdir()}
    assert scripts >= EXECUTABLES
    marker = tmp_path / "env/share/ament_index/resource_index/packages/uav_tracking_mpc"
    assert marker.is_file()
    command = tmp_path / "env" / "bin" / "uav_tracking"
    (library,) = (tmp_path / "env").glob("lib/python*/site-packages")
    assert_whole(library, checkout)
    words = ["stability", "--config", "small_uav", "--json"]  # finds its configurations
    assert run(command, *words, cwd=tmp_path, PYTHONPATH=str(library)).startswith("{")


def test_ros_wheels_are_an_extra_and_no_requirement():
    text = (ROOT / "setup.py").read_text()
    requirements = text[text.index("install_requires") : text.index("extras_require")]
    assert "ros-" not in requirements
    assert "ros-jazzy-rclpy[fastrtps]==" in text


def test_versions_agree():
    assert PACKAGE.findtext("version") == __version__
    assert f'version="{__version__}"' in (ROOT / "setup.py").read_text()
    assert f"version: {__version__}\n" in (ROOT / "CITATION.cff").read_text()
    dated = rf"^## {re.escape(__version__)} \(\d{{4}}-\d\d-\d\d\)$"
    assert re.search(dated, (ROOT / "CHANGELOG.md").read_text(), flags=re.MULTILINE)


def test_package_xml_names_every_import():
    """By rosdep key; what only some commands need is an extra and has none."""
    keys = {
        "argcomplete": "python3-argcomplete",
        "casadi": "casadi-pip",
        "hypothesis": "python3-hypothesis",
        "jinja2": "python3-jinja2",
        "matplotlib": "python3-matplotlib",
        "mpl_toolkits": "python3-matplotlib",
        "numba": "python3-numba",
        "llvmlite": "python3-numba",
        "numpy": "python3-numpy",
        "PIL": "python3-pil",
        "pymavlink": "python3-pymavlink-pip",
        "pytest": "python3-pytest",
        "rich": "python3-rich",
        "rosbags": "python3-rosbags-pip",
        "scipy": "python3-scipy",
        "yaml": "python3-yaml",
    }
    named = KEYS
    started = re.findall(r'package="(\w+)"', (ROOT / "launch/tracking.launch.py").read_text())
    assert {*started, "ros2bag", "ros2launch", "rosbag2_storage_mcap"} <= named
    own = {path.stem for path in (ROOT / "test").rglob("*.py")}
    known = {*sys.stdlib_module_names, "uav_tracking_mpc", *own, *EXTRAS} - {*keys}
    for folder in ("uav_tracking_mpc", "launch", "test", "examples"):
        for file in (ROOT / folder).rglob("*.py"):
            tree = ast.parse(file.read_text())
            modules = set()
            for node in ast.walk(tree):
                if isinstance(node, ast.Import):
                    modules |= {alias.name for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    modules.add(node.module)
            for module in {name.partition(".")[0] for name in modules}:
                assert module in known or keys.get(module, module) in named, f"{file}: {module}"


def test_rosdep_knows_every_key_of_package_xml():
    """On Ubuntu 24.04 with Jazzy, as looked up in rosdistro; see rosdep_keys.txt."""
    lines = (ROOT / "test" / "rosdep_keys.txt").read_text().splitlines()
    assert not KEYS - {line for line in lines if not line.startswith("#")}


def test_commands_let_rosdep_install_by_pip():
    assert any(key.endswith("-pip") for key in KEYS)
    for page in (ROOT / "README.md", *ROOT.glob("docs/**/*.md")):
        for line in re.findall(r"^.*rosdep install.*$", page.read_text(), flags=re.MULTILINE):
            assert line.startswith("PIP_BREAK_SYSTEM_PACKAGES=1 rosdep install"), page


def test_every_test_is_collected_or_left_out_by_name_without_the_extras():
    """As in `colcon test` on a machine that has what package.xml declares and no more."""
    program = (
        f"import sys; sys.modules.update(dict.fromkeys({sorted(EXTRAS)})); import pytest;"
        "sys.exit(pytest.main(['--collect-only', '-q', 'test']))"
    )
    printed = run(sys.executable, "-c", program, cwd=ROOT)
    assert "pymavlink is not installed" in printed
    assert "test/nodes/test_nmpc_controller.py::" in printed
    assert int(re.findall(r"(\d+)(?:/\d+)? tests collected", printed)[0]) > 3000


def test_the_source_distribution_is_complete(checkout, tmp_path):
    """A test in it finds everything that it finds in the repository."""
    files = {str(path.relative_to(checkout)) for path in checkout.rglob("*") if path.is_file()}
    shutil.copytree(checkout, tmp_path / "copy", ignore=shutil.ignore_patterns(*BUILT))
    run(sys.executable, "setup.py", "-q", "sdist", "-d", tmp_path, cwd=tmp_path / "copy")
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        packed = {name.partition("/")[2] for name in opened.getnames()}
    assert not {name for name in files - packed if name.partition("/")[0] not in BUILT}


def test_package_xml_says_who_and_where():
    assert {url.get("type") for url in PACKAGE.findall("url")} == {
        "website",
        "repository",
        "bugtracker",
    }
    assert PACKAGE.findtext("author")
    assert {element.text for element in PACKAGE.findall("test_depend")} >= {"python3-pytest-xdist"}
