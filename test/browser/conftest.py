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

"""Chromium for the tests of the live page, and a flight to show."""

from __future__ import annotations

import os
import shutil

import pytest

pytest.importorskip("msgspec")  # which comes with the page
from seen_page import SeenPage, served

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--disable-background-networking", "--disable-component-update", "--disable-gpu",
    "--disable-quic", "--disable-sync", "--no-first-run", "--no-proxy-server",
)  # fmt: skip


@pytest.fixture(scope="session")
def chromium():
    """A browser without a window."""
    pytest.importorskip("viser", reason="the live page needs viser")
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("there is no chromium on the path: `apt-get install chromium`")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def context(chromium):
    """Tabs and cookies of one file of tests."""
    context = chromium.new_context(viewport={"width": 900, "height": 480})
    yield context
    context.close()


@pytest.fixture
def look(context):
    """Opens a page in a new tab, for one test: ``look(address)``."""
    seen = []

    def look(address, **options):
        seen.append(SeenPage(context.new_page(), address, **options))
        return seen[-1]

    yield look
    for page in seen:
        page.page.close()


@pytest.fixture(scope="module")
def page(source):
    """The page that the tests of one file share, of its source."""
    with served(source) as page:
        yield page


@pytest.fixture(scope="module")
def opened(context, page):
    """That page in the browser."""
    return SeenPage(context.new_page(), page.address)


@pytest.fixture(scope="session")
def flight():
    """20 s of the paper's mission: its log, and what its controller flew by."""
    from uav_tracking_mpc import load_configuration, simulate

    configuration = load_configuration("paper", ["mission.duration=20.0"])
    return simulate(configuration), configuration.controller
