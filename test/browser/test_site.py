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

"""What the documentation adds to its theme, in a browser: style, script, order of results."""

import pytest
from sources import ROOT

pytestmark = pytest.mark.browser

STATIC = ROOT / "docs" / "_static"
NAME = "uav_tracking_mpc.dynamics.relative_models.kinematics"
CELL = f"<td><code class='literal'><span class='pre'>{NAME}</span></code></td>"
PAGE = f"""<style>
body {{ margin: 0 }} .table-wrapper {{ width: 100% }} span.pre {{ white-space: nowrap }}
</style>
<style>{(STATIC / "site.css").read_text()}</style>
<div class="main"><div class="content"><article>
<div class="table-wrapper"><table class="docutils"><tr>{CELL * 2}</tr></table></div>
<div class="table-wrapper"><table class="docutils"><tr>{CELL * 8}</tr></table></div>
<p>{"word " * 40} <math><mi>x</mi></math>, and more.</p>
<div class="highlight"><pre>make demo\nmake view\n</pre></div>
</article></div></div>
<script>{(STATIC / "site.js").read_text()}</script>"""
OVER = "element => element.scrollWidth - element.clientWidth"


@pytest.fixture(scope="module", params=[1280, 390])
def page(chromium, request):
    """A page of tables, a formula and code; the clipboard needs a secure context."""
    context = chromium.new_context(viewport={"width": request.param, "height": 800})
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.route(
        "https://site.test/", lambda route: route.fulfill(body=PAGE, content_type="text/html")
    )
    page.goto("https://site.test/")
    yield page
    context.close()


def test_a_table_of_long_names_fits(page):
    assert page.locator(".table-wrapper").first.evaluate(OVER) == 0


def test_a_table_that_is_too_wide_scrolls_and_the_page_does_not(page):
    wide = page.locator(".table-wrapper").last
    assert wide.evaluate(OVER) > 0 or page.viewport_size["width"] > 400
    assert page.locator("html").evaluate(OVER) == 0
    assert page.locator("td").first.inner_text() == NAME


def test_a_formula_keeps_its_comma(page):
    together = page.locator("span:has(> math)")
    assert together.text_content() == "x,"
    assert together.evaluate("element => getComputedStyle(element).whiteSpace") == "nowrap"


def test_a_button_copies_the_code(page):
    page.evaluate("window.setTimeout = () => 0")  # so that the word stays until it is read
    page.locator(".highlight button").click()
    page.locator(".highlight button", has_text="copied").wait_for()
    assert page.evaluate("navigator.clipboard.readText()") == "make demo\nmake view\n"


def test_pages_of_text_are_found_before_attributes(page):
    page.add_script_tag(path=ROOT / "docs" / "search_scorer.js")
    names = ["reference/api", "reference/constants", "tutorial"]
    found = [(name, score) for name in names for score in (2, 26)]
    scores = [page.evaluate("Scorer.score", [n, "", "", "", s, "", ""]) for n, s in found]
    assert scores == sorted(scores)
