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

"""The legend says what every colour means."""

from uav_tracking_mpc.report.mode_colours import MODE_COLOURS
from uav_tracking_mpc.view.panel.legend import legend
from uav_tracking_mpc.view.scene._drawing import LIMIT, WIND


def test_every_colour_has_its_words():
    words = legend((1, 2, 3))
    for colour in (*MODE_COLOURS.values(), WIND, LIMIT, (1, 2, 3)):
        assert f"rgb{colour}" in words
    for mode in MODE_COLOURS:
        assert mode.value in words
    assert "Drag the target" in words
