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

"""Whether a folder can be written is known before anything is flown, and nothing is left behind."""

from unittest import mock

import pytest

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.cli.output_folder import check_writable
from uav_tracking_mpc.parameters.specification import ParameterError


def test_a_folder_that_can_be_written_stays_as_it_was(tmp_path):
    check_writable(tmp_path)
    check_writable(tmp_path / "new" / "deep")
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_its_place_and_a_folder_that_cannot_be_made_are_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(ParameterError, match="must be a folder that can be written: it is a file"):
        check_writable(file)
    for folder in (file / "below", "/proc/nowhere"):
        with pytest.raises(ParameterError, match="must be a folder that can be written"):
            check_writable(tmp_path / folder)
    with (
        mock.patch("tempfile.TemporaryFile", side_effect=OSError(28, "No space left on device")),
        pytest.raises(ParameterError, match="No space left on device"),
    ):
        check_writable(tmp_path / "new")
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate"],
        ["fly"],
        ["compare"],
        ["campaign", "robustness"],
        ["margins"],
        ["identify", "--validate", "1"],
        ["stability"],
        ["benchmark"],
        ["torture"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_every_command_looks_before_it_works(arguments, tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("")
    assert main([*arguments, "--output", str(file)]) == 2
    said = capsys.readouterr()
    assert "must be a folder that can be written: it is a file" in said.err
    assert said.out == ""
    assert "simulating" not in said.err


def test_a_page_that_is_not_there_is_refused_at_once(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["campaign", "robustness", "--page", str(tmp_path / "nowhere.md")])
    assert ended.value.code == 2
    assert "there is no file" in capsys.readouterr().err
