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

"""The stability command: the ellipsoid's analysis, and what is said where there is none."""

import json

import pytest

from uav_tracking_mpc.studies.stability import stability_study

QUICK = ("--set", "nmpc_controller.model=paper")  # (11) is proved in a tenth of the exact's time


def test_json_is_one_object_and_the_certificate_verifies(tmp_path, uav_tracking, monkeypatch):
    # Seconds: test/studies/stability/test_paper_report.py.
    monkeypatch.setattr(stability_study, "paper_report", list)
    content = uav_tracking.json("stability", *QUICK, "--output", tmp_path, "--figures")
    assert content["certified"] is True
    assert content["paper_as_printed"]["holds"] is False
    assert content["config"] == "paper"
    assert json.loads((tmp_path / "stability.json").read_text()) == content
    for name in ("ellipsoid.png", "decrease.png"):
        assert (tmp_path / name).stat().st_size < 300_000
    verified = uav_tracking.json("stability", "--verify", tmp_path / "certificate.json")
    assert verified["accepted"] is True


@pytest.mark.parametrize("text", ["{}", "[]", "no JSON"])
def test_what_is_no_certificate_is_rejected(text, tmp_path, uav_tracking):
    path = tmp_path / "c.json"
    path.write_text(text)
    ended = uav_tracking("stability", "--verify", path)
    assert ended.code == 1
    assert "REJECTED" in ended.out
    assert str(path) in ended.out or text == "{}"


def test_an_artificial_orbit_has_guarantees_instead(uav_tracking):
    text = uav_tracking.told("stability", "--config", "small_uav")
    for words in ("Guaranteed.", "Not guaranteed.", "ellipsoid"):
        assert words in text


def test_a_campaign_is_one_object(tmp_path, uav_tracking):
    few = ("--campaign", 2, "--jobs", 1, "--output", tmp_path)
    content = uav_tracking.json("stability", "--config", "small_uav", *few)
    assert content["terminal_constraint"] == "artificial_orbit"
    assert (content["states"], content["steps"]) == (2, 80)
    assert content["clean"] is True
    assert json.loads((tmp_path / "stability.json").read_text()) == content
