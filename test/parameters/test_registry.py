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

"""Extensions by name: those of a room, of a file, of a module; and what is refused in words."""

import importlib
import os
import pickle
import sys
from importlib import metadata

import pytest
from processes import scripted

from uav_tracking_mpc.laws import GUIDANCE_LAW
from uav_tracking_mpc.limits import LIMIT
from uav_tracking_mpc.parameters import registry
from uav_tracking_mpc.parameters.registry import ExtensionError, ExtensionPoint, did_you_mean
from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import MissionParameters, SimulatorParameters
from uav_tracking_mpc.settings.tracking import TrackingParameters

ROOMS = [
    room.parent.relative_to(registry.PACKAGE.parent)
    for room in registry.PACKAGE.rglob("__init__.py")
    if "= ExtensionPoint(" in room.read_text(encoding="utf-8")
]
KINDS = [
    value
    for room in ROOMS
    for value in vars(importlib.import_module(".".join(room.parts))).values()
    if isinstance(value, ExtensionPoint)
]
CEILING = """
from dataclasses import dataclass
from uav_tracking_mpc.limits import Bound, Limit
from uav_tracking_mpc.parameters.specification import parameter

@dataclass(frozen=True)
class Ceiling(Limit):
    name = "ceiling"
    on_ground = True
    ceiling: float = parameter(500.0, "Greatest height in map.", unit="m", lower=0.0, upper=1e4)

    def numbers(self, targets):
        return self.ceiling - targets[:, 2:]

    def stage(self, motion, numbers, xp):
        return Bound(motion.z, upper=numbers[0], scale=5.0)
"""


@pytest.fixture
def ceiling(tmp_path):
    path = tmp_path / "ceiling_limit.py"
    path.write_text(CEILING)
    return f"{path}:Ceiling"


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.title)
def test_every_file_of_every_room_holds_what_its_name_says(kind):
    for name, found in kind.all().items():
        assert issubclass(found, kind.base)
        assert found.name == name


def test_a_class_of_a_file_is_found(ceiling):
    assert LIMIT.find(ceiling) is LIMIT.find(ceiling)
    assert LIMIT.find(ceiling).name == "ceiling"


def test_two_files_of_one_name_are_two(tmp_path):
    for folder, ceiling in (("one", 1.0), ("other", 2.0)):
        (tmp_path / folder).mkdir()
        words = CEILING.replace("parameter(500.0", f"parameter({ceiling}")
        (tmp_path / folder / "mine.py").write_text(words)
    one, other = (LIMIT.find(f"{tmp_path / each}/mine.py:Ceiling") for each in ("one", "other"))
    assert [one().ceiling, other().ceiling] == [1.0, 2.0]
    assert pickle.loads(pickle.dumps(one())) == one()  # refused where the other took its place


def test_a_folder_may_be_named_in_any_encoding(tmp_path):
    folder = tmp_path / os.fsdecode(b"gr\xf6\xdfe")  # as Latin-1 wrote it
    folder.mkdir()
    (folder / "mine.py").write_text(CEILING)
    assert LIMIT.find(f"{folder}/mine.py:Ceiling").name == "ceiling"


def test_an_entry_point_is_found(monkeypatch):
    point = metadata.EntryPoint("mine", "uav_tracking_mpc.laws.l1:L1Loiter", GUIDANCE_LAW.room)
    monkeypatch.setattr(registry, "entry_points", lambda group: (point,))
    assert "mine" in GUIDANCE_LAW.names
    assert GUIDANCE_LAW.find("mine") is GUIDANCE_LAW.find("l1")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("no_such", "law is 'no_such', must be one of l1, npfg, vector_field, or path.py:Class"),
        ("nowhere.py:Law", "there is no file .*nowhere.py"),
        ("os.path:join", "must derive from uav_tracking_mpc.laws.GuidanceLaw"),
        ("os.path:Law", "os.path has no Law"),
        ("no_such_module:Law", "cannot be loaded: ModuleNotFoundError"),
    ],
)
def test_what_is_not_there_is_refused_in_words(name, words):
    with pytest.raises(ExtensionError, match=words):
        GUIDANCE_LAW.find(name)


def test_a_file_that_fails_is_named_with_its_error(tmp_path):
    path = tmp_path / "broken.py"
    path.write_text("1 / 0")
    with pytest.raises(ExtensionError, match="broken.py:Law' cannot be loaded: ZeroDivisionError"):
        GUIDANCE_LAW.find(f"{path}:Law")


def test_a_further_limit_brings_its_parameters(ceiling):
    values = {"limits": ceiling, "ceiling": 90.0}
    parameters = from_mapping(TrackingParameters, values)
    assert parameters.ceiling == 90.0
    assert parameters.envelope.ceiling == 90.0
    assert "ceiling" in [limit.name for limit in parameters.envelope.limits]
    assert pickle.loads(pickle.dumps(parameters)) == parameters
    with pytest.raises(ParameterError, match="'ceiling' is -1.0, must be a number from 0"):
        from_mapping(TrackingParameters, {**values, "ceiling": -1.0})
    with pytest.raises(ParameterError, match="'ceiling' is unknown"):
        from_mapping(TrackingParameters, {"ceiling": 90.0})


def test_an_installed_limit_is_in_force_where_it_is_named(ceiling, monkeypatch):
    found = LIMIT.find(ceiling)
    point = metadata.EntryPoint("ceiling", f"{found.__module__}:Ceiling", LIMIT.room)
    monkeypatch.setattr(registry, "entry_points", lambda group: (point,))
    assert "ceiling" not in [limit.name for limit in TrackingParameters().envelope.limits]
    named = from_mapping(TrackingParameters, {"limits": "ceiling", "ceiling": 90.0})
    assert named.envelope.ceiling == 90.0


def test_a_limit_named_twice_or_one_of_the_project_is_installed_once(ceiling):
    usual = TrackingParameters().envelope.limits
    assert from_mapping(TrackingParameters, {"limits": "fence"}).envelope.limits == usual
    twice = from_mapping(TrackingParameters, {"limits": f"{ceiling}, fence, {ceiling}"})
    assert len(twice.envelope.limits) == len(usual) + 1


def test_an_extension_that_fails_is_named_and_left_out(monkeypatch, caplog):
    point = metadata.EntryPoint("mine", "no_such_module:Law", GUIDANCE_LAW.room)
    monkeypatch.setattr(registry, "entry_points", lambda group: (point,))
    assert list(GUIDANCE_LAW.all()) == GUIDANCE_LAW.own_names
    assert "guidance law 'mine' cannot be loaded: ModuleNotFoundError" in caplog.text
    with pytest.raises(ExtensionError, match="'mine' cannot be loaded"):
        GUIDANCE_LAW.find("mine")


def test_a_broken_installed_limit_stops_no_program(tmp_path):
    (tmp_path / "broken_limit.py").write_text("1 / 0")
    installed = tmp_path / "broken-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (installed / "entry_points.txt").write_text(f"[{LIMIT.room}]\nmine = broken_limit:Mine\n")
    program = (
        "from uav_tracking_mpc import TrackingParameters, load_configuration\n"
        "print(len(TrackingParameters().envelope.limits))\n"
        "try:\n    load_configuration('paper', ['nmpc_controller.limits=mine'])\n"
        "except ValueError as error:\n    print(error)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    _, said, _ = scripted(program, env=environment)
    count, words = said.splitlines()
    assert int(count) == len(TrackingParameters().envelope.limits)
    assert "'mine' cannot be loaded: ZeroDivisionError" in words


def test_every_set_of_parameters_is_checked_however_it_is_made():
    with pytest.raises(ParameterError, match="'horizon' is 0, must be an integer from 1"):
        TrackingParameters(horizon=0)
    with pytest.raises(ParameterError, match="'control_rate' is -1.0"):
        TrackingParameters(control_rate=-1.0)
    with pytest.raises(ParameterError, match="'speed' is -1.0"):
        SimulatorParameters(speed=-1.0)
    assert isinstance(TrackingParameters(range=60).range, float)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rnage", " (did you mean 'range'?)"),
        ("RANGE", " (did you mean 'range'?)"),
        ("wind", ""),
        ("range", ""),  # it is one of them: not the name is wrong
        (3, ""),
    ],
)
def test_only_a_near_name_is_suggested(name, words):
    assert did_you_mean(name, ["range", "altitude"]) == words


@pytest.mark.parametrize(
    ("meant", "mistake"),
    [
        ("duration", lambda: from_mapping(MissionParameters, {"duraton": 1.0})),
        ("vehicle", lambda: from_mapping(MissionParameters, {"plant": "vehicel"})),
        ("npfg", lambda: GUIDANCE_LAW.find("nfpg")),
        ("small_uav", lambda: load_configuration("small_uv")),
        ("crosswind", lambda: load_configuration("paper", scenario="croswind")),
        ("nmpc_controller", lambda: load_configuration("paper", ["nmpc_controler.range=150.0"])),
    ],
)
def test_every_refusal_of_a_name_suggests(meant, mistake):
    with pytest.raises((ParameterError, ExtensionError), match=f"did you mean '{meant}'"):
        mistake()


def test_an_unknown_section_of_a_file_suggests(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("uav_simulater: {ros__parameters: {speed: 1.0}}")
    with pytest.raises(ParameterError, match="did you mean 'uav_simulator'"):
        load_configuration(str(file))
