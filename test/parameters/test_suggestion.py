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

"""What may have been meant by a mistyped name."""

import pytest

from uav_tracking_mpc.parameters.registry import GUIDANCE_LAW, ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping
from uav_tracking_mpc.parameters.suggestion import did_you_mean
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.mission import MissionParameters


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


def test_every_refusal_of_a_name_suggests():
    with pytest.raises(ParameterError, match="did you mean 'duration'"):
        from_mapping(MissionParameters, {"durration": 1.0})
    with pytest.raises(ParameterError, match="did you mean 'vehicle'"):
        from_mapping(MissionParameters, {"plant": "vehicel"})
    with pytest.raises(ExtensionError, match="did you mean 'npfg'"):
        GUIDANCE_LAW.find("nfpg")
    with pytest.raises(ParameterError, match="did you mean 'small_uav'"):
        load_configuration("small_uv")
    with pytest.raises(ParameterError, match="did you mean 'crosswind'"):
        load_configuration("paper", scenario="croswind")
    with pytest.raises(ParameterError, match="did you mean 'nmpc_controller'"):
        load_configuration("paper", ["nmpc_controler.range=150.0"])


def test_an_unknown_section_of_a_file_suggests(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("uav_simulater: {ros__parameters: {speed: 1.0}}")
    with pytest.raises(ParameterError, match="did you mean 'uav_simulator'"):
        load_configuration(str(file))
