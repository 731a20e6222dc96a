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

"""The colour and the words of each fallback mode, in figures, scene and panel alike."""

from __future__ import annotations

from uav_tracking_mpc.control.fallback import FallbackMode

Colour = tuple[int, int, int]

# Okabe and Ito's, told apart by everybody, on a light background and on a dark one: cool where a
# fresh plan or the law that was asked for is flown, warm where the flight lives on less.
MODE_COLOURS: dict[FallbackMode, Colour] = {
    FallbackMode.OPTIMAL: (0, 158, 115),
    FallbackMode.GUIDANCE_LAW: (0, 114, 178),
    FallbackMode.FEASIBLE: (86, 180, 233),
    FallbackMode.EARLIER_PLAN: (230, 159, 0),
    FallbackMode.LOITER: (213, 94, 0),
    FallbackMode.HOLD: (204, 121, 167),
    FallbackMode.SILENCE: (128, 128, 128),
}


def mode_colour(mode: FallbackMode | None) -> Colour:
    """Red, green, blue from 0 to 255.

    Args:
        mode: What is flown; None, before the first command, looks like silence.
    """
    return MODE_COLOURS[FallbackMode.SILENCE if mode is None else mode]


def mode_words(mode: FallbackMode | None) -> str:
    """What is flown, in words.

    Args:
        mode: None before the first command.
    """
    return "no command yet" if mode is None else mode.value
