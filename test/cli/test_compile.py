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

import json

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.control import guidance
from uav_tracking_mpc.mpc import compiled_method, machine_code


class Quick(compiled_method.Compilation):
    """Compiles nothing."""

    def wait(self):
        self.close()
        (self.folder / machine_code.DESCRIPTION).write_text("{}")


def test_it_says_what_was_compiled_and_where_it_is_kept(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(guidance, "Compilation", Quick)
    assert main(["compile", "--config", "small_uav", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert first["compiled"] is True
    assert first["config"] == "small_uav"
    assert first["folder"].startswith(str(tmp_path))
    assert main(["compile", "--config", "small_uav", "--json"]) == 0
    second = json.loads(capsys.readouterr().out)
    assert second == {**first, "compiled": False, "seconds": 0.0}
    assert main(["compile", "--config", "small_uav"]) == 0
    assert "solver is compiled already, kept in" in capsys.readouterr().out


def test_another_problem_is_compiled_anew(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(guidance, "Compilation", Quick)
    folders = []
    for setting in ("nmpc_controller.horizon=12", "nmpc_controller.horizon=13"):
        assert main(["compile", "--set", setting, "--json"]) == 0
        folders.append(json.loads(capsys.readouterr().out)["folder"])
    assert folders[0] != folders[1]


def test_a_law_needs_nothing(capsys):
    assert main(["compile", "--set", "nmpc_controller.law=l1"]) == 0
    assert capsys.readouterr().out == "paper: nothing has to be compiled for it\n"


def test_what_is_not_allowed_is_refused(capsys):
    assert main(["compile", "--config", "no_such"]) == 2
    assert "no_such" in capsys.readouterr().err
