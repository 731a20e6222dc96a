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

"""Two texts that say the same: word for word, and number for number to their last digit."""

from __future__ import annotations

import re

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def last_digit(number: str) -> float:
    """What one step of the last digit of a printed number is worth."""
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def assert_same(found: str, expected: str) -> None:
    """Fail where words differ, or a decimal number by more than one step of its last digit.

    The last digit that a table prints depends on how a library of linear algebra rounds.
    """
    assert NUMBER.split(found) == NUMBER.split(expected)
    for one, other in zip(NUMBER.findall(found), NUMBER.findall(expected), strict=True):
        step = max(last_digit(one), last_digit(other)) if "." in one + other else 0.0
        assert abs(float(one) - float(other)) <= 1.001 * step, f"{one} is not {other}"
