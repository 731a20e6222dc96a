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

import importlib
import re

import pytest
from processes import run, scripted

from uav_tracking_mpc.cli.main import COMMANDS


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["simulate", "--config", "mars"], 2, "configuration is 'mars', must be a file or one of"),
        (["simulate", "--set", "nmpc_controller.range=1"], 2, "orbit range is 1.0 m"),
        (["simulate", "--duration", "-1"], 2, "parameter 'duration' is -1.0"),
        (["fly", "--speed", "1e9"], 2, "parameter 'speed' is 1000000000.0"),
        (["simulate", "--duration", "5", "--output", "/proc/nowhere"], 2, "/proc/nowhere"),
        (["simulate", "--duration", "long"], 2, "'long' is not a number from 1 to 1e+06 s"),
        (["simulate", "--plant", "glider"], 2, "'glider'"),
        (["simulate", "--speed", "2"], 2, "unrecognized arguments: --speed 2"),
        (["simulate", "--config", "papr"], 2, "did you mean 'paper'?"),
        (["stability", "--config", "paper.yaml"], 2, "did you mean 'paper'?"),
        (["benchmark", "--seed", "-1"], 2, "'-1' is not an integer at least 0"),
        (["torture", "--seed", "-1"], 2, "'-1' is not an integer at least 0"),
        (["monitor", "--namespace", "7up"], 2, "'7up' is not a namespace"),
        (["identify", "nowhere.csv"], 2, "there is no bag or CSV file 'nowhere.csv'"),
        (
            ["simulate", "--set", "uav_simulator.initial_position=[0,0,50]"],
            1,
            "the Euler plant has no value there",
        ),
        (["fly", "--domain-id", "500"], 2, "'500' is not an integer from 0 to 232"),
        (["benchmark", "--cold", "-3"], 2, "--cold"),
        (["autopilot", "--connection", "radio"], 2, "connection is 'radio', must be"),
        (["autopilot", "--set", "uav_simulator.plant=balloon"], 2, "'balloon'"),
        (["autopilot", "--origin", "95,0,0"], 2, "'95,0,0' is not LAT,LON,ALT"),
        (["campaign", "storm"], 2, "campaign is 'storm', must be a file or one of lag_sweep"),
        (["campaign", "robustness", "--laws", "pid"], 2, "'law' is 'pid', must be one of"),
        (["campaign", "robustness", "--flights", "0"], 2, "'0' is not an integer at least 1"),
        (["campaign", "robustness", "--page", "nowhere.md"], 2, "there is no file"),
        (
            ["campaign", "robustness", "--set", "wind.sped=3"],
            2,
            "'wind.sped' must be SECTION.PARAMETER",
        ),
        (["campaign", "robustness", "--set", "wind.speed={uniform: [3]}"], 2, "must have 2 values"),
        (
            ["campaign", "robustness", "--workers", "2", "--scheduler", "tcp://x:1"],
            2,
            "not allowed with",
        ),
        (["compare", "--scenario", "storm"], 2, "scenario is 'storm', must be a file or one of"),
        (["compare", "--laws", "pid"], 2, "invalid choice: 'pid'"),
        (["compare", "--law", "nowhere.py:Pursuit"], 2, "there is no file"),
        (["compare", "--config", "mars"], 2, "configuration is 'mars'"),
        (["compare", "--mismatch", "lag_9"], 2, "invalid choice: 'lag_9'"),
        (
            ["compare", "--mismatch", "lag_0", "--scenario", "still"],
            2,
            "not allowed with argument --mismatch",
        ),
        (["identify"], 2, "either a bag or CSV file, or --validate N"),
        (["margins", "--scenario", "storm"], 2, "scenario is 'storm'"),
        (["stability", "--verify", "none.json"], 2, "none.json"),
        *(
            (["stability", "--config", "small_uav", option], 2, f"{option} is about the ellipsoid")
            for option in ("--design", "--maps", "--figures")
        ),
        (["view", "none.mcap"], 2, "there is no bag none.mcap"),
        (["view", "none.mcap", "--set", "nmpc_controller.range=3"], 2, "needs --config"),
        *((["view", "--port", port], 2, "from 0 to 65535") for port in ("-1", "65536", "http")),
        *(
            (["fly", *words], 2, f"{words[0]} needs --view")
            for words in (["--port", "0"], ["--host", "0.0.0.0"], ["--no-browser"])
        ),
        *(
            (["fly", *words], 2, f"{words[0]} needs --link")
            for words in (
                ["--engage"],
                ["--simulated"],
                ["--connection", "udpin:127.0.0.1:14550"],
                ["--target-system", "3"],
            )
        ),
        (
            ["fly", "--link", "px4", "--simulated", "--connection", "udpin:127.0.0.1:14550"],
            2,
            "leave --connection out",
        ),
        (["hover"], 2, "invalid choice: 'hover'"),
        ([], 2, "required: COMMAND"),
    ],
)
def test_mistakes_are_explained_without_a_traceback(arguments, code, words, uav_tracking):
    refusal = uav_tracking.refused(*arguments, code=code)
    assert words in refusal
    assert "Traceback" not in refusal


def test_a_process_ends_with_its_code():
    code, output = run("cli.main", "hover")
    assert code == 2
    assert "invalid choice: 'hover'" in output
    assert "Traceback" not in output


def test_help_teaches(uav_tracking):
    text = uav_tracking.told("--help")
    for word in (*COMMANDS, "examples:"):
        assert word in text


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_it_does(name, uav_tracking):
    text = uav_tracking.told(name, "--help")
    module = importlib.import_module(f"uav_tracking_mpc.cli.{name}")
    assert " ".join(module.DESCRIPTION.split()) in " ".join(text.split())
    options = re.findall(r"^  (--\S+)( .*)?$", text, re.MULTILINE)
    assert options or name in ("monitor", "link")


def test_help_imports_nothing_that_takes_long():
    program = (
        "import uav_tracking_mpc.cli.main as cli\n"
        "try: cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "slow = {'numpy', 'casadi', 'matplotlib', 'scipy', 'numba', 'rich'}\n"
        "print(sorted(slow & set(sys.modules)))"
    )
    _, output, _ = scripted(program)
    assert output.endswith("[]\n"), output
