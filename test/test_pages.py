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

"""The comparison of pages lets the last digit move and nothing else."""

import pytest
from pages import assert_same

TEXT = "| varrho | 3.1733 | -1.2e-05 | row 12 | L2 |"


@pytest.mark.parametrize(("old", "new"), [("3.1733", "3.1734"), ("-1.2e-05", "-1.1e-05")])
def test_the_last_digit_may_move(old, new):
    assert_same(TEXT.replace(old, new), TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [("3.1733", "3.1735"), ("-1.2e-05", "1.2e-05"), ("12", "13"), ("L2", "L3"), ("row", "line")],
)
def test_nothing_else_may(old, new):
    with pytest.raises(AssertionError):
        assert_same(TEXT.replace(old, new), TEXT)
