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

"""What the shell is offered, asked for as the shell asks."""

import functools
import io
import os
import subprocess
import sys

import pytest

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.cli.program import _import_when_used, settings

argcomplete = pytest.importorskip("argcomplete")
SLOW = ("casadi.casadi", "numba", "scipy", "matplotlib", "rclpy")


def asking(line):
    """What a shell sets that asks."""
    return {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\013",
        "_ARGCOMPLETE_COMP_WORDBREAKS": " \t\n\"'><;|&(",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
    }


def completions(line, module="main", tail=""):
    """Words that are offered behind a line, and whatever is printed besides."""
    program = (
        f"import sys\nfrom uav_tracking_mpc.cli.{module} import main\n"
        "import atexit, os\n"
        "end = os._exit\n"
        "def look(code):\n"
        f"    slow = sorted(set({SLOW!r}) & set(sys.modules))\n"
        "    sys.stderr.write(f'slow={slow}'); sys.stderr.flush(); end(code)\n"
        f"os._exit = look\n{tail}main()"
    )
    read, write = os.pipe()
    finished = subprocess.run(
        ["bash", "-c", f'exec 8>&{write}; exec "$@"', "bash", sys.executable, "-c", program],
        capture_output=True,
        text=True,
        pass_fds=(write,),
        env={**os.environ, **asking(line)},
        timeout=900,
    )
    os.close(write)
    with os.fdopen(read) as answer:
        words = {word.strip() for word in answer.read().split("\013") if word.strip()}
    return words, finished


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("uav_tracking sim", {"simulate"}),
        ("uav_tracking simulate --dur", {"--duration"}),
        ("uav_tracking simulate --config sm", {"small_uav"}),
        ("uav_tracking simulate --scenario head", {"headwind"}),
        ("uav_tracking fly --law np", {"npfg"}),
        ("uav_tracking simulate --plant js", {"jsbsim"}),
        ("uav_tracking campaign rob", {"robustness"}),
        ("uav_tracking link ch", {"check"}),
        ("uav_tracking link check --link ar", {"ardupilot"}),
        ("uav_tracking autopilot --dialect p", {"px4"}),
        ("uav_tracking simulate --set mission.dur", {"mission.duration="}),
        ("uav_tracking simulate --set mission.plant=eu", {"mission.plant=euler"}),
        ("uav_tracking compare --laws nmpc l", {"l1"}),
    ],
)
def test_commands_options_and_names_are_offered(line, offered, monkeypatch):
    said, ask = io.StringIO(), argcomplete.CompletionFinder()
    asked = functools.partial(ask, exit_method=sys.exit, output_stream=said)
    monkeypatch.setattr(argcomplete, "autocomplete", asked)
    monkeypatch.setattr(os, "fdopen", lambda *_: sys.stderr)  # the shell's files are not there
    for name, value in asking(line).items():
        monkeypatch.setenv(name, value)
    with pytest.raises(SystemExit):
        main()
    assert {word.strip() for word in said.getvalue().split("\013")} == offered


@pytest.mark.parametrize(
    ("line", "module", "offered"),
    [
        ("uav_tracking simulate --set mission.plant=eu", "main", {"mission.plant=euler"}),
        ("launch_tracking --config sm", "launch_tracking", {"small_uav"}),
    ],
)
def test_a_shell_is_answered_at_once(line, module, offered):
    words, finished = completions(line, module)
    assert words == offered, finished.stderr
    assert finished.stderr.endswith("slow=[]"), finished.stderr
    assert finished.stdout == ""


def test_every_parameter_is_offered():
    names = set(settings("nmpc"))
    assert "nmpc_controller.range=" in names
    assert {f"nmpc_controller.model={name}" for name in ("paper", "exact")} <= set(
        settings("nmpc_controller.model=")
    )
    assert list(settings("uav_simulator.publish_clock=")) == [
        "uav_simulator.publish_clock=true",
        "uav_simulator.publish_clock=false",
    ]
    assert list(settings("mission.duration=")) == []


def test_an_import_that_was_put_off_happens_at_the_first_use(tmp_path, monkeypatch):
    (tmp_path / "put_off.py").write_text("answer = 42")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "put_off", raising=False)
    _import_when_used("put_off")
    later = sys.modules["put_off"]
    assert not hasattr(later, "__file__")
    assert later.answer == 42
    assert sys.modules["put_off"].__file__ == str(tmp_path / "put_off.py")


def test_without_the_library_the_command_goes_on():
    tail = "sys.modules['argcomplete'] = None\nsys.argv = ['uav_tracking', '--version']\n"
    _, finished = completions("uav_tracking sim", tail=tail)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.strip()
