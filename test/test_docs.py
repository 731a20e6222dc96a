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

"""What README and documentation say is what the code does. make docs tests the build itself."""

import doctest
import re
from pathlib import Path

import pytest
from constants import PACKAGE, constants, of_source

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.nodes.ros.node_reference import tables

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
REFERENCE = DOCS / "reference" / "topics_and_parameters.md"
PAGES = [
    page
    for page in sorted((*DOCS.rglob("*.md"), *ROOT.glob("*.md")))
    if "_build" not in page.parts and page.name != "README.md"
]


def test_tables_are_those_of_the_code(tmp_path):
    page = tmp_path / REFERENCE.name
    page.write_text(REFERENCE.read_text())
    for name, table in tables().items():
        table.write_into(page, name)
    assert page.read_text() == REFERENCE.read_text(), "run `make docs`"
    assert len(tables()["nmpc_controller"].rows) > 18


@pytest.fixture(scope="module")
def found():
    """Constants of the package: to find them takes seconds."""
    return list(constants())


def test_every_number_with_a_name_is_a_constant(found):
    listed = {constant.key for constant in found}
    for path in sorted(PACKAGE.rglob("*.py")):
        name = str(path.relative_to(PACKAGE))
        if not re.match("estimation/|control/adaptation|mpc/newton/stage", name):
            for named in re.findall(r"^([A-Z_][A-Z_\d]*)(?:: .*)? = -?\d", path.read_text(), re.M):
                assert f"{name} {named}" in listed


def test_every_constant_has_a_unit_or_a_kind(found):
    assert [constant.key for constant in found if not constant.kind] == []


def test_comments_of_constants_are_read():
    code = "WAIT, SHARE = 2, 0.5  # s, -: of both\n\n# bits of a mask\nMASK = 0b11\nWORD = 'x'"
    read = [(c.name, c.unit, c.kind) for c in of_source("control/x.py", code)]
    assert read == [("WAIT", "s", "time"), ("SHARE", "-", "ratio"), ("MASK", "", "code")]
    assert [c.kind for c in of_source("control/x.py", "BARE = 3.0")] == [""]
    assert [c.kind for c in of_source("view/x.py", "BARE = 3.0")] == ["display"]


def test_links_lead_somewhere():
    """On the repository's pages; the links of the site are checked when it is built."""
    for page in PAGES:
        text = page.read_text()
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
            if "://" not in link:
                assert (page.parent / link).exists(), f"{page}: {link}"
        for included in re.findall(r"\{(?:literalinclude|include)\} (\S+)", text):
            assert (page.parent / included).exists(), f"{page}: {included}"


def test_files_that_are_named_exist():
    for page in PAGES:
        text = page.read_text()
        for name in re.findall(r"`((?:uav_tracking_mpc|test|config|examples|docs)/[\w./]+)`", text):
            assert (ROOT / name).exists(), f"{page}: {name}"
        for name in re.findall(r"`([a-z_]+/[\w./]+\.py)`", text):
            own = ROOT / "uav_tracking_mpc" / name
            assert (ROOT / name).exists() or own.exists(), f"{page}: {name}"


def test_every_page_is_in_the_site():
    listed = {"index"}
    for index in (DOCS / "index.md", DOCS / "how_to" / "index.md"):
        for block in re.findall(r"```\{toctree\}(.*?)```", index.read_text(), flags=re.DOTALL):
            folder = index.parent.relative_to(DOCS)
            listed |= {str(folder / line) for line in block.split() if ":" not in line}
    for page in DOCS.rglob("*.md"):
        if "_build" not in page.parts:
            assert str(page.relative_to(DOCS).with_suffix("")) in listed, page


def test_examples_of_the_python_interface_run():
    page = DOCS / "reference" / "api.md"
    blocks = re.findall(r"```python\n(>>>.*?)```", page.read_text(), flags=re.DOTALL)
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, page.name, str(page), 0)
    results = doctest.DocTestRunner().run(test)
    assert results.attempted > 15
    assert results.failed == 0


def test_no_bag_is_played_beside_a_clock_of_its_own():
    """Bags of `fly` hold /clock."""
    for page in PAGES:
        assert not re.search(r"bag play .*--clock", page.read_text()), page


TEXT = (ROOT / "README.md").read_text()


def test_it_is_short():
    assert len(TEXT.splitlines()) <= 110


def test_its_links_lead_somewhere():
    for link in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert "://" in link or (ROOT / link).exists(), link


def test_its_snippet_names_what_the_package_has():
    (names,) = re.findall(r"from uav_tracking_mpc import (.*)", TEXT)
    for name in names.split(", "):
        assert hasattr(__import__("uav_tracking_mpc"), name)


def test_its_commands_are_known(capsys):
    for command in set(re.findall(r"uav_tracking (\w+)", TEXT)):
        with pytest.raises(SystemExit) as ending:
            main([command, "--help"])
        assert ending.value.code == 0, command
        capsys.readouterr()


def test_its_ros_commands_have_their_arguments_behind_ros_args():
    for line in re.findall(r"ros2 run .*", TEXT):
        assert "params-file" not in line or "--ros-args --params-file" in line
