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

"""A browser is opened only where somebody sits before it, and it says nothing on stdout."""

import os

import pytest
from processes import scripted

from uav_tracking_mpc.view.serving.browser import is_watched


@pytest.mark.parametrize(
    ("environment", "platform", "watched"),
    [
        ({}, "linux", False),
        ({"DISPLAY": ":0"}, "linux", True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, "linux", True),
        ({"DISPLAY": ":0", "CI": "true"}, "linux", False),
        ({"DISPLAY": ":0", "CI": "false"}, "linux", True),
        ({"SSH_CONNECTION": "1 2 3 4"}, "linux", False),
        ({"SSH_CONNECTION": "1 2 3 4", "DISPLAY": "localhost:10"}, "linux", True),
        ({}, "darwin", True),
        ({"SSH_CONNECTION": "1 2 3 4"}, "darwin", False),
    ],
)
def test_only_where_there_is_a_screen(environment, platform, watched):
    assert is_watched(environment, platform) is watched


def test_it_opens_a_file_that_leads_to_the_address_and_is_not_waited_for(tmp_path):
    opened, kept = tmp_path / "opened", tmp_path / "kept.html"
    browser = tmp_path / "browser.sh"
    browser.write_text(
        f'#!/bin/sh\necho words\necho "$1" > {opened}.part\nmv {opened}.part {opened}\n'
    )
    browser.chmod(0o755)
    program = (
        f"import os, pathlib, time; home = pathlib.Path({str(tmp_path)!r})\n"
        "from uav_tracking_mpc.view.serving.browser import open_browser\n"
        "with open_browser('http://127.0.0.1:1/?token=secret'):\n"
        f"    while not pathlib.Path({str(opened)!r}).exists(): time.sleep(0.05)\n"
        f"    os.link(next(home.glob('uav_tracking_page_*')), {str(kept)!r})\n"
    )
    env = {**os.environ, "BROWSER": str(browser), "HOME": str(tmp_path)}
    assert scripted(program, env=env) == (0, "", "")
    assert opened.read_text().startswith((tmp_path / "uav_tracking_page_").as_uri())
    assert 'href="http://127.0.0.1:1/?token=secret"' in kept.read_text()
    assert kept.stat().st_mode & 0o077 == 0  # the user's own
    assert list(tmp_path.glob("uav_tracking_page_*")) == []
