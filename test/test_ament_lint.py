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

"""ROS 2's own linters find nothing, where they are installed: `colcon test` brings them.

Quotes, line length, the style of docstrings and the licence on each file are ruff's; setup.cfg
lists what differs and why. flake8 and pep257 run as docs/ros.md tells people to run them.
"""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = ("docs", "examples", "launch", "test", "uav_tracking_mpc", "setup.py")

pytestmark = pytest.mark.linter


def paths(*names):
    return [str(ROOT / name) for name in names]


def documented(program):
    """Arguments of a program in docs/ros.md."""
    text = (ROOT / "docs" / "ros.md").read_text().replace("\\\n", "")
    (line,) = re.findall(rf"^{program} (.*)$", text, flags=re.MULTILINE)
    assert set(shlex.split(line)) >= set(SOURCES)
    return shlex.split(line)


@pytest.fixture(autouse=True)
def in_the_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_flake8():
    arguments = documented("ament_flake8")
    flake8 = pytest.importorskip("ament_flake8.main")
    code, errors = flake8.main_with_errors(argv=arguments)
    assert code == 0, "\n".join(errors)


def test_pep257():
    arguments = documented("ament_pep257")
    pep257 = pytest.importorskip("ament_pep257.main")
    assert pep257.main(argv=arguments) == 0


def test_xmllint():
    xmllint = pytest.importorskip("ament_xmllint.main")
    assert xmllint.main(argv=["package.xml", "config"]) == 0


def test_copyright():
    copyright_ = pytest.importorskip("ament_copyright.main")
    assert copyright_.main(argv=paths(*SOURCES)) == 0
