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

"""The page on stability: its pictures exist and are small."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_pictures_of_the_page_exist_and_are_small():
    names = re.findall(r"!\[.*?\]\((.*?)\)", (DOCS / "stability.md").read_text())
    assert len(names) >= 3
    for name in names:
        assert 0 < (DOCS / name).stat().st_size < 300_000
