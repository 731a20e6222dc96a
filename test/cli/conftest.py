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

"""The command as a shell has it, in this process."""

import json
from typing import NamedTuple

import pytest

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.report import mission_report
from uav_tracking_mpc.report.metrics import metrics


class Ended(NamedTuple):
    """A command that has ended: its exit code, and what it has printed."""

    code: int
    out: str
    err: str


class Command:
    """The program ``uav_tracking``."""

    def __init__(self, capsys):
        self._capsys = capsys

    def __call__(self, *words):
        try:
            code = main([*map(str, words)])
        except SystemExit as ended:
            code = ended.code
        return Ended(code, *self._capsys.readouterr())

    def told(self, *words):
        """What it tells people, as it does what is asked for."""
        ended = self(*words)
        assert ended.code == 0, ended.err
        return ended.out

    def json(self, *words):
        """What it prints for programs: one object and nothing else."""
        return json.loads(self.told(*words, "--json"))

    def refused(self, *words, code=2):
        """Why it refuses, with nothing printed besides."""
        ended = self(*words)
        assert (ended.code, ended.out) == (code, ""), ended.err
        return ended.err


@pytest.fixture
def uav_tracking(capsys):
    return Command(capsys)


@pytest.fixture
def without_report(monkeypatch):
    """A report's figures take longer than a short flight."""
    monkeypatch.setattr(mission_report, "write_report", lambda log, *_: metrics(log))
