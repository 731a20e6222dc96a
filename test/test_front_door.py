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

"""What ``from uav_tracking_mpc import ...`` gives, and that the example of its docstring runs."""

import ast
import doctest
import importlib
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import uav_tracking_mpc
from uav_tracking_mpc.dynamics import frames


def test_every_name_is_there():
    for name in uav_tracking_mpc.__all__:
        value = getattr(uav_tracking_mpc, name)
        assert name == "__version__" or value.__name__ == name
        assert name in dir(uav_tracking_mpc)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'Contoller'"):
        _ = uav_tracking_mpc.Contoller


def test_type_checkers_see_the_same_names():
    tree = ast.parse(Path(uav_tracking_mpc.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: node.module.removeprefix("uav_tracking_mpc.")
        for node in block.body
        for alias in node.names
    }
    assert seen == uav_tracking_mpc._HOMES


def test_the_import_alone_loads_nothing_heavy():
    program = "import sys, uav_tracking_mpc; print({'numpy', 'casadi', 'numba'} & {*sys.modules})"
    finished = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert finished.stdout.strip() == "set()", finished.stderr


def test_the_example_of_the_docstring_runs():
    results = doctest.testmod(uav_tracking_mpc, verbose=False)
    assert results.attempted > 5
    assert results.failed == 0


def test_new_places_of_the_migration_page_are_there():
    page = Path(__file__).parents[1] / "docs" / "migration.md"
    table = page.read_text().split("## Imports")[1].split("## ")[0]
    places = [
        place
        for line in table.splitlines()[4:]
        for place in re.findall(r"`(uav_tracking_mpc[\w.]+)`", line.partition(" | ")[2])
    ]
    assert len(places) > 20
    for place in places:
        assert pydoc.locate(place) is not None, place


def test_what_examples_taught_to_import_is_there_and_tells_its_new_place():
    sys.modules.pop("uav_tracking_mpc.dynamics.angles", None)
    with pytest.warns(DeprecationWarning, match="uav_tracking_mpc.dynamics.frames"):
        moved = importlib.import_module("uav_tracking_mpc.dynamics.angles")
    assert moved.wrap_angle is frames.wrap_angle
