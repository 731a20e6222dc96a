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

"""The script is put into what viser serves, once, whatever its data hold."""

import re
from pathlib import Path

import pytest

from uav_tracking_mpc.view.serving.page_script import SCRIPT, STYLE, own, with_script


@pytest.fixture(scope="module")
def page():
    viser = pytest.importorskip("viser")
    build = Path(viser.__file__).parent / "client" / "build" / "index.html"
    return build.read_text(encoding="utf-8")


def test_title_and_icon_take_the_place_of_visers(page):
    made = with_script(page, "a <flight>")
    head = made.partition("</head>")[0]
    assert re.findall("<title>(.*?)</title>", head)[0] == "a &lt;flight&gt;"
    assert "Viser</title>" not in made
    assert len(re.findall(r'<link\s+rel="icon"', head)) == 1
    assert own(SCRIPT) in head and own(STYLE) in head


def test_it_stands_before_the_bundle_and_after_the_charset(page):
    made = with_script(page)
    assert made.index("<meta charset") < made.index(own(SCRIPT)) < made.index("<script data-p=")
    assert made.index("<meta charset") < 1000  # browsers look for it there


def test_data_end_no_script(page):
    made = with_script(page, record={"events": [[0.0, 1, "</script><script>alert(1)"]]})
    assert "</script><script>alert" not in made


def test_nan_is_refused(page):
    with pytest.raises(ValueError, match="JSON"):
        with_script(page, record={"begin": float("nan")})


@pytest.mark.parametrize("lost", ["<title>Viser</title>", "</head>", "<meta charset"])
def test_another_page_is_refused(page, lost):
    with pytest.raises(ValueError, match="no page of viser"):
        with_script(page.replace(lost, ""))


def test_the_script_asks_nobody_else():
    assert not re.search(r"https?://(?!www\.(w3|apache)\.org)", own(SCRIPT) + own(STYLE))
