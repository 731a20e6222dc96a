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

from __future__ import annotations

import pytest

from uav_tracking_mpc.control import guidance
from uav_tracking_mpc.mpc import compiled_method, machine_code


class Quick(compiled_method.Compilation):
    """Compiles nothing."""

    def wait(self):
        self.close()
        (self.folder / machine_code.DESCRIPTION).write_text("{}")


@pytest.fixture
def quick(monkeypatch, tmp_path):
    """Nothing is compiled, into an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(guidance, "Compilation", Quick)


def test_it_says_what_was_compiled_and_where_it_is_kept(quick, tmp_path, uav_tracking):
    words = ("compile", "--config", "small_uav")
    first = uav_tracking.json(*words)
    assert first["compiled"] is True
    assert first["config"] == "small_uav"
    assert first["folder"].startswith(str(tmp_path))
    assert uav_tracking.json(*words) == {**first, "compiled": False, "seconds": 0.0}
    assert "solver is compiled already, kept in" in uav_tracking.told(*words)


def test_another_problem_is_compiled_anew(quick, uav_tracking):
    one, other = (
        uav_tracking.json("compile", "--set", f"nmpc_controller.horizon={stages}")["folder"]
        for stages in (12, 13)
    )
    assert one != other


def test_a_law_needs_nothing(uav_tracking):
    told = uav_tracking.told("compile", "--set", "nmpc_controller.law=l1")
    assert told == "paper: nothing has to be compiled for it\n"
