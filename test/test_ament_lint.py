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

Quotes, line length and the style of docstrings are ruff's; setup.cfg lists what differs and why.
"""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = ("docs", "examples", "launch", "test", "uav_tracking_mpc", "setup.py")
# Of pydocstyle's Google convention; what it says about tests, which need no docstring, and about
# first lines stands in setup.cfg for flake8, too.
PEP257 = ("D100", "D101", "D102", "D103", "D104", "D105", "D106", "D107", "D402", "D403")

pytestmark = pytest.mark.linter


def paths(*names):
    return [str(ROOT / name) for name in names]


@pytest.mark.timeout(600)
def test_flake8():
    flake8 = pytest.importorskip("ament_flake8.main")
    code, errors = flake8.main_with_errors(
        argv=["--config", str(ROOT / "setup.cfg"), *paths(*SOURCES)]
    )
    assert code == 0, "\n".join(errors)


@pytest.mark.timeout(600)
def test_pep257():
    pep257 = pytest.importorskip("ament_pep257.main")
    arguments = ["--convention", "google", "--add-ignore", *PEP257, "--"]
    assert pep257.main(argv=[*arguments, *paths(*SOURCES)]) == 0


def test_xmllint(tmp_path):
    xmllint = pytest.importorskip("ament_xmllint.main")
    before = Path.cwd()
    os.chdir(ROOT)
    try:
        assert xmllint.main(argv=["package.xml", "config"]) == 0
    finally:
        os.chdir(before)


def test_copyright():
    copyright_ = pytest.importorskip("ament_copyright.main")
    assert copyright_.main(argv=paths(*SOURCES)) == 0
