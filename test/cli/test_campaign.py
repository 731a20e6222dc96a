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

"""The command from end to end, killed and resumed, and what it refuses."""

import json
import subprocess
import time

import pytest
from campaign_files import SHORT, written
from processes import command, environment, wait_for
from pyarrow import parquet

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.cli.program import explanation
from uav_tracking_mpc.studies.campaign import campaign_run
from uav_tracking_mpc.studies.campaign.campaign_run import fly_batch


def run(*arguments, limit=280):
    return subprocess.run(
        command("cli.main", "campaign", *map(str, arguments)),
        capture_output=True,
        text=True,
        env=environment(),
        timeout=limit,
    )


def test_a_campaign_that_was_killed_goes_on_and_flies_nothing_twice(tmp_path):
    draw = {**SHORT["draw"], "mission.duration": 5.0}
    file, output = written(tmp_path, draw=draw, flights=24), tmp_path / "out"
    arguments = [file, "--workers", 2, "--output", output, "--json"]
    process = subprocess.Popen(
        command("cli.main", "campaign", *map(str, arguments)),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=environment(),
    )
    try:
        assert wait_for(lambda: any(output.glob("batches/*.parquet")))
    finally:
        process.kill()
        process.wait()
    time.sleep(0.5)  # its processes end when they see that
    kept = {path.name: path.stat().st_mtime_ns for path in output.glob("batches/*.parquet")}
    there = sum(parquet.read_metadata(output / "batches" / f).num_rows for f in kept)
    finished = run(*arguments)
    assert finished.returncode == 0, finished.stderr
    content = json.loads(finished.stdout)
    assert (content["flights"], content["flown"]) == (24, 24 - there)
    assert json.loads((output / "campaign.json").read_text()) == content
    assert parquet.read_metadata(output / "flights.parquet").num_rows == 24
    # From another folder, without a break: the same.
    whole = run(file, "--workers", 1, "--output", tmp_path / "whole", "--json")
    assert whole.returncode == 0, whole.stderr
    assert (tmp_path / "whole/flights.parquet").read_bytes() == (
        output / "flights.parquet"
    ).read_bytes()


def test_an_interrupted_campaign_tells_what_it_found_and_goes_on(tmp_path, monkeypatch, capsys):
    words = ["campaign", str(written(tmp_path)), "--workers", "1", "--output", str(tmp_path / "o")]
    batches = []

    def interrupting(campaign, batch):
        if batches:
            raise KeyboardInterrupt
        batches.append(len(batch))
        return fly_batch(campaign, batch)

    monkeypatch.setattr(campaign_run, "fly_batch", interrupting)
    assert main([*words, "--json"]) == 130
    found = capsys.readouterr()
    content = json.loads(found.out)
    (flown,) = batches
    assert content["flights"] == content["flown"] == flown
    assert f"interrupted: {6 - flown} flights are left" in found.err
    assert (tmp_path / "o" / "campaign.html").is_file()
    monkeypatch.undo()
    assert main([*words, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert (content["flights"], content["flown"]) == (6, 6 - flown)


def test_people_get_tables(tmp_path):
    finished = run(
        written(tmp_path), "--flights", 2, "--laws", "vector_field", "--set", "wind.speed=2.0",
        "--workers", 1, "--output", tmp_path / "out",
    )  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    assert "vector_field" in finished.stdout
    assert "bounds" in finished.stdout
    assert "a minute and worker" in finished.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["storm"], "campaign is 'storm', must be a file or one of lag_sweep"),
        (["robustness", "--set", "wind.sped=3"], "'wind.sped' must be SECTION.PARAMETER"),
        (["robustness", "--set", "wind.speed={uniform: [3]}"], "must have 2 values"),
        (["robustness", "--laws", "pid"], "'law' is 'pid', must be one of"),
        (["robustness", "--flights", "0"], "'0' is not an integer at least 1"),
        (["robustness", "--workers", "2", "--scheduler", "tcp://x:1"], "not allowed with"),
    ],
)
def test_mistakes_are_explained(arguments, words, tmp_path):
    finished = run(*arguments, "--output", tmp_path / "out")
    assert finished.returncode == 2
    assert words in finished.stderr
    assert finished.stdout == ""


def test_an_extra_that_is_missing_is_named():
    error = ModuleNotFoundError("No module named 'pyarrow'", name="pyarrow")
    assert explanation(error) == (
        2, "pyarrow is not installed: `pip install 'uav_tracking_mpc[campaign]'`",
    )  # fmt: skip
