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

"""What README.md, the first page of the site, tutorials and how-to pages tell people to type works.

Commands are the lines of the blocks of code without a language. ``make test`` is left out, and so
are blocks for a ROS 2 from apt. A comment tells what a command does other than end with 0: "exit
code 2", "until Ctrl-C". In short every command goes through the parser of its program; at length
all are run, one after the other, in a fresh clone and the environment that its `make demo` makes.
"""

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from processes import wait_for
from sources import ROOT, copied

from uav_tracking_mpc.cli import main as program
from uav_tracking_mpc.cli import options as options
from uav_tracking_mpc.report import mission_report
from uav_tracking_mpc.report.metrics import metrics

ADDRESS = "https://github.com/uav-tracking-mpc/uav_tracking_mpc"
DOCS, README = ROOT / "docs", ROOT / "README.md"
TUTORIALS = tuple(
    DOCS / name
    for name in ("tutorial.md", "tutorials/your_aircraft.md", "tutorials/reproduce_the_paper.md")
)
AUTOPILOT = DOCS / "tutorials" / "arduplane.md"
PAGES = (*TUTORIALS, AUTOPILOT, README, DOCS / "index.md")
HOW_TO = sorted((DOCS / "how_to").glob("*.md"))
FROM_APT = ("ros2", "colcon", "rosdep")
SHELL = ("cd", "export", "git")
PATIENCE = 1800.0  # s, for one command on a loaded machine
OTHER_ENVIRONMENT = (  # of the interpreter that runs the tests, and of the make that may run it
    "LD_LIBRARY_PATH", "MAKEFLAGS", "MAKELEVEL", "MFLAGS", "PYTHONPATH", "VIRTUAL_ENV",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
)  # fmt: skip


def commands(page):
    """Lines that a reader types, in their order."""
    text = page.read_text().replace("\\\n", " ")
    found = re.findall(r"^```(.*?)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    blocks = [block.splitlines() for language, block in found if not language]
    ours = [
        block
        for block in blocks
        if not any(word in FROM_APT for line in block for word in line.split()[:2])
    ]
    return [line for block in ours for line in block if line.strip() and line != "make test"]


def exit_code(line):
    """The exit code that a line tells."""
    told = re.search(r"#.*exit code (\d+)", line)
    return int(told[1]) if told else 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_is_understood(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = commands(page)
    assert len(lines) > (2 if page == AUTOPILOT else 4)
    for line in lines:
        for words in _split(shlex.split(line, comments=True)):
            assert _understood(words, monkeypatch) == exit_code(line), line


@pytest.mark.parametrize("page", HOW_TO, ids=lambda page: page.stem)
def test_every_command_of_a_how_to_page_is_understood(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(ROOT / "examples")
    for name in ("my_uav.yaml", "my_link.py", "shuttle.py"):  # the reader's
        shutil.copy(ROOT / "config" / "small_uav.yaml", name)
    for line in commands(page):
        words = shlex.split(line, comments=True)
        assert _understood(words, monkeypatch) == exit_code(line), line


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_every_simulation_of_a_tutorial_flies(page, tmp_path, monkeypatch):
    """As it is written, but for its length; at length it is flown with all other commands."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(mission_report, "write_report", _written)
    shutil.copy(ROOT / "config" / "small_uav.yaml", "my_uav.yaml")
    for line in commands(page):
        words = shlex.split(line, comments=True)
        if words[:2] != ["uav_tracking", "simulate"]:
            continue
        try:
            code = program.main([*words[1:], "--duration", "3"])
        except SystemExit as ending:
            code = ending.code
        assert code == exit_code(line), line
        folder = words[words.index("--output") + 1] if "--output" in words else "output"
        assert code or Path(folder, "report.html").is_file(), line


def _written(log, output, record_scene):
    """Instead of a report, whose figures take longer than the flight."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "report.html").touch()
    return metrics(log)


def _split(words):
    """The commands of a line that are joined by ``&&``."""
    while "&&" in words:
        end = words.index("&&")
        yield words[:end]
        words = words[end + 1 :]
    yield words


def _understood(words, monkeypatch):
    """Exit code of a command that is parsed, configured and not run."""
    if words[0] == "uav_tracking":
        _check_files(words[1:])
        if not words[1].startswith("-"):
            monkeypatch.setattr(f"uav_tracking_mpc.cli.{words[1]}.run", _configured)
        try:
            return program.main(words[1:])
        except SystemExit as ending:
            return ending.code
    if words[0] == "make":
        return subprocess.run(["make", "-n", *words[1:]], cwd=ROOT, capture_output=True).returncode
    if words[0] == "cp":
        shutil.copy(ROOT / words[1], words[2])
        return 0
    if words[0] == "python":
        return 0 if (ROOT / words[1]).is_file() else 2
    assert words[0] in SHELL, f"nothing here knows {words[0]!r}"
    return 0


def _configured(parsed):
    """Instead of what a command does: what it would fly is read and checked."""
    if hasattr(parsed, "config") and hasattr(parsed, "overrides"):
        scenarios = getattr(parsed, "scenario", None)
        for one in scenarios if isinstance(scenarios, list) else [scenarios]:
            options.chosen_configuration(parsed, one)
    return 0


def _check_files(words):
    """Files that are named are there, or in the folder of an earlier command: both are made."""
    for option, word in zip(["", *words], words, strict=False):
        if option == "--output":
            Path(word).mkdir(parents=True)
        elif re.search(r"\.\w+$", word) and "=" not in word:
            path = Path(word)
            if path.parent != Path() and path.parent.exists():
                path.touch()
            assert path.exists() or (ROOT / path).exists(), word


class Reader:
    """Types a page's commands into a shell: folder and environment stay from line to line.

    Args:
        folder: Where the reader begins.
        checkout: What `git clone` brings.
    """

    def __init__(self, folder, checkout):
        self.folder, self._notes = folder, folder / "after"
        self.environment = {k: v for k, v in os.environ.items() if k not in OTHER_ENVIRONMENT}
        self.environment |= {
            "GIT_CONFIG_COUNT": "1",
            "GIT_CONFIG_KEY_0": f"url.{checkout}.insteadOf",
            "GIT_CONFIG_VALUE_0": ADDRESS,
        }

    def type(self, line):
        """Exit code and output of a line."""
        script = f"{line}\ncode=$?\npwd > {self._notes}; env -0 >> {self._notes}; exit $code"
        output = self._notes.with_suffix(".txt")
        with output.open("w") as told:
            process = subprocess.Popen(
                ["bash", "-c", script],
                cwd=self.folder,
                env=self.environment,
                stdout=told,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            if "until Ctrl-C" in line:
                assert wait_for(
                    lambda: "http://" in output.read_text() or process.poll() is not None, PATIENCE
                )
                os.killpg(process.pid, signal.SIGINT)
            code = process.wait(PATIENCE)
            if line.startswith("make") and code == -signal.SIGINT:
                code = 0  # make ends itself by the signal when what it ran has ended
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        if "until Ctrl-C" not in line:
            folder, _, variables = self._notes.read_text().partition("\n")
            self.folder = Path(folder)
            pairs = (pair.partition("=") for pair in variables.split("\0") if pair)
            self.environment = {name: value for name, _, value in pairs}
        return code, output.read_text()


@pytest.fixture
def reader(tmp_path):
    """Somebody in an empty folder, and a repository with the sources as they are."""
    checkout = copied(tmp_path / "published")
    git = ["git", "-C", checkout, "-c", "user.name=reader", "-c", "user.email=reader@localhost"]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "published"]):
        subprocess.run([*git, *words], check=True)
    (tmp_path / "home").mkdir()
    return Reader(tmp_path / "home", checkout)


@pytest.mark.long
@pytest.mark.nodes
def test_every_command_does_what_is_said(reader):
    """The first tutorial from the clone on, then the others and the README in that clone."""
    wrong = []
    for page in (*TUTORIALS, README):
        for line in commands(page):
            code, output = reader.type(line)
            print(f"$ {line}\n{output[-2000:]}", flush=True)
            if code != exit_code(line):
                wrong.append(f"{line}: exit code {code}\n{output[-2000:]}")
            for folder in re.findall(r"--output (\S+)", line):
                if not list((reader.folder / folder).glob("*.*")):
                    wrong.append(f"{line}: nothing is in {folder}")
        text = page.read_text()
        for name in re.findall(r"`((?:output/)?[\w/]+\.(?:html|json|mcap|yaml))`", text):
            if not (reader.folder / name).exists() and not list(
                reader.folder.glob(f"output/**/{name}")
            ):
                wrong.append(f"{page.name} promises {name}")
    assert not wrong, "\n".join(wrong)
