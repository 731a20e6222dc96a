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

import dataclasses
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from solver_problems import paper

from uav_tracking_mpc.mpc import machine_code, method_cache


@pytest.fixture
def places(monkeypatch, tmp_path):
    """Cache of the user and directory for temporary files."""
    cache, temp = tmp_path / "cache", tmp_path / "temp"
    temp.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setattr(method_cache.tempfile, "gettempdir", lambda: str(temp))
    return cache, temp


def test_without_a_writable_home_the_cache_is_under_temp(places):
    cache, temp = places
    cache.write_text("")  # no directory can be made there
    assert method_cache.cache_directory().parent == temp


def test_what_is_compiled_is_found_where_nothing_can_be_written(places, monkeypatch):
    cache, temp = places
    folder = method_cache.method_folder(paper())
    assert folder.parent.parent == cache
    (folder / machine_code.DESCRIPTION).write_text("{}")
    monkeypatch.setattr(method_cache, "cache_directory", lambda: temp)
    assert method_cache.method_folder(paper()) == folder


def test_machine_code_of_another_user_is_not_run(places, monkeypatch):
    folder = method_cache.method_folder(paper())
    (folder / machine_code.DESCRIPTION).write_text("{}")
    monkeypatch.setattr(method_cache.os, "getuid", lambda: folder.stat().st_uid + 1)
    monkeypatch.setattr(Path, "stat", lambda path, stat=Path.stat: _of_user(stat(path), 12345))
    assert not method_cache._ours(folder.parent)


@pytest.mark.parametrize("mode", [0o770, 0o707])
def test_machine_code_that_others_can_write_is_not_run(places, mode):
    folder = method_cache.method_folder(paper())
    (folder / machine_code.DESCRIPTION).write_text("{}")
    folder.parent.chmod(mode)
    assert method_cache.method_folder(paper()).parent != folder.parent


def _of_user(found, user):
    class Stat:
        st_uid = user
        st_mode = found.st_mode

    return Stat()


def test_a_slower_process_drops_its_draft(places):
    cache, _ = places
    cache.mkdir()
    sources = {"__init__.py": "", "stage.py": "N = 1\n"}
    folder = cache / "newton_test"
    for _ in range(2):
        method_cache._install(folder, sources)
    assert [path.name for path in cache.iterdir()] == ["newton_test"]
    assert {file.name: file.read_text() for file in folder.iterdir()} == sources


def test_the_name_changes_with_the_expressions_and_the_horizon_alone():
    problem = paper()
    name = method_cache._digest(problem)
    assert method_cache._digest(paper()) == name
    wider = dataclasses.replace(problem, input_upper=2.0 * problem.input_upper)
    assert method_cache._digest(wider) == name  # bounds are data
    assert method_cache._digest(dataclasses.replace(problem, horizon=7)) != name
    dearer = dataclasses.replace(problem, stage_cost=2.0 * problem.stage_cost)
    assert method_cache._digest(dearer) != name
    equal = dataclasses.replace(problem, terminal_equality=problem.state[:1])
    assert method_cache._digest(equal) != name
    assert isinstance(problem.state, ca.SX)
    assert np.isfinite(problem.input_upper).all()


def test_the_name_changes_with_the_toolchain(monkeypatch):
    problem = paper()
    name = method_cache._digest(problem)
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    method_cache._toolchain.cache_clear()
    try:
        assert method_cache._digest(problem) != name
    finally:
        method_cache._toolchain.cache_clear()
