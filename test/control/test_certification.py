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

"""What is claimed of the terminal set is true at every moment of a change."""

import shutil
from dataclasses import replace

import pytest
import small_uav

from uav_tracking_mpc.control import certification
from uav_tracking_mpc.control.certification import NEITHER, SAMPLED, CertificateStatus, ClaimWatch
from uav_tracking_mpc.settings.configuration import configuration_folder
from uav_tracking_mpc.settings.tracking import TrackingParameters

FOLDER = configuration_folder() / "certificates"
HARD = TrackingParameters(terminal_constraint="hard")


def test_a_certificate_holds_for_its_orbit_alone():
    told = []
    watch = ClaimWatch(HARD, FOLDER, told.append)
    assert watch.claim.status == "certified"
    watch.change(replace(HARD, range=160.0))
    watch.wait()
    assert watch.claim.status == SAMPLED
    assert told == [f"terminal set sampled: {watch.claim.reason}"]
    watch.change(HARD)
    watch.wait()
    assert watch.claim.status == "certified"


def test_a_damaged_file_beside_a_certificate_hides_none(tmp_path):
    shutil.copytree(FOLDER, tmp_path, dirs_exist_ok=True)
    (tmp_path / "zzz.json").write_text("{")
    (tmp_path / "aaa.json").write_bytes(b"\xff")
    assert certification.certification(HARD, tmp_path).status == "certified"


def test_nothing_is_claimed_until_the_new_orbit_is_judged(monkeypatch):
    watch = ClaimWatch(HARD, FOLDER, lambda words: None)
    meanwhile, second = [], replace(HARD, range=161.0)

    def slow(parameters, folder):
        meanwhile.append(watch.claim)
        return CertificateStatus(SAMPLED, f"{parameters.range:g} m")

    monkeypatch.setattr(certification, "certification", slow)
    watch.change(second)
    watch.wait()
    (claim,) = meanwhile
    assert claim.status == NEITHER
    assert "161 m at 50 m and 4 m/s is new and not judged yet" in claim.reason
    assert watch.claim.reason == "161 m"
    watch.change(replace(second, plan_age_max=9.0))
    watch.wait()
    assert len(meanwhile) == 1  # the orbit is the same


@pytest.mark.parametrize("error", [OSError("gone"), ValueError("no set")])
def test_what_cannot_be_judged_is_not_claimed(monkeypatch, error):
    watch = ClaimWatch(HARD, FOLDER, lambda words: None)

    def fails(parameters, folder):
        raise error

    monkeypatch.setattr(certification, "certification", fails)
    watch.change(replace(HARD, range=162.0))
    watch.wait()
    assert watch.claim == CertificateStatus(NEITHER, str(error))


def test_by_construction_it_holds_for_every_orbit():
    parameters = small_uav.parameters()
    watch = ClaimWatch(parameters, FOLDER, None)
    before = watch.claim
    watch.change(replace(parameters, range=333.0))
    assert watch.claim is before
