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

from campaign_files import SHORT, written
from processes import started, wait_for
from pyarrow import parquet

from uav_tracking_mpc.studies.campaign import campaign_run
from uav_tracking_mpc.studies.campaign.campaign_run import fly_batch


def test_a_campaign_that_was_killed_goes_on_and_flies_nothing_twice(tmp_path, uav_tracking):
    draw = {**SHORT["draw"], "mission.duration": 2.0}
    file, output = written(tmp_path, draw=draw, flights=12, settled_after=1.0), tmp_path / "out"
    arguments = ("campaign", file, "--workers", 2, "--output", output, "--json")
    with started("cli.main", *arguments) as process:
        assert wait_for(lambda: any(output.glob("batches/*.parquet")))
        process.kill()
        process.communicate()  # its processes end when they see that, and close its streams
    kept = [parquet.read_metadata(path) for path in output.glob("batches/*.parquet")]
    there = sum(batch.num_rows for batch in kept)
    content = uav_tracking.json(*arguments[:-1])
    assert (content["flights"], content["flown"]) == (12, 12 - there)
    assert json.loads((output / "campaign.json").read_text()) == content
    assert parquet.read_metadata(output / "flights.parquet").num_rows == 12
    # From another folder, without a break: the same.
    whole = tmp_path / "whole"
    uav_tracking.told("campaign", file, "--workers", 1, "--output", whole)
    flown = (whole / "flights.parquet").read_bytes()
    assert flown == (output / "flights.parquet").read_bytes()


def test_an_interrupted_campaign_tells_what_it_found_and_goes_on(
    tmp_path, monkeypatch, uav_tracking
):
    words = ("campaign", written(tmp_path), "--workers", 1, "--output", tmp_path / "o")
    batches = []

    def interrupting(campaign, batch):
        if batches:
            raise KeyboardInterrupt
        batches.append(len(batch))
        return fly_batch(campaign, batch)

    with monkeypatch.context() as patched:
        patched.setattr(campaign_run, "fly_batch", interrupting)
        found = uav_tracking(*words, "--json")
    assert found.code == 130
    content = json.loads(found.out)
    (flown,) = batches
    assert content["flights"] == content["flown"] == flown
    assert f"interrupted: {6 - flown} flights are left" in found.err
    assert (tmp_path / "o" / "campaign.html").is_file()
    content = uav_tracking.json(*words)
    assert (content["flights"], content["flown"]) == (6, 6 - flown)


def test_people_get_tables(tmp_path, uav_tracking):
    told = uav_tracking.told(
        "campaign", written(tmp_path), "--flights", 2, "--laws", "vector_field",
        "--set", "wind.speed=2.0", "--workers", 1, "--output", tmp_path / "out",
    )  # fmt: skip
    for words in ("vector_field", "bounds", "a minute and worker"):
        assert words in told
