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

"""Formulas of the documentation as a browser without a mathematical font draws them."""

import importlib.util
import io
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("docutils", reason="formulas are converted by docutils")
pytestmark = pytest.mark.browser

FILE = Path(__file__).parents[2] / "docs" / "_extensions" / "mathml.py"
SIZE = 60  # pixels of a letter


@pytest.fixture(scope="module")
def converted():
    """What the site makes of a formula."""
    specification = importlib.util.spec_from_file_location("mathml", FILE)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module.converted


@pytest.fixture(scope="module")
def drawn(context, converted):
    """A formula on a page, in the font of text: what a machine without a better one takes."""
    page = context.new_page()

    def draw(formula):
        style = f"body, math {{ font: {SIZE}px 'Liberation Serif', serif }} math {{ padding: 1em }}"
        page.set_content(f"<style>{style}</style><p>{converted(formula)}</p>")
        return page

    return draw


def ink(page):
    """Rows of the picture of a formula on which something is drawn."""
    shot = Image.open(io.BytesIO(page.screenshot())).convert("L")
    return np.flatnonzero((np.asarray(shot) < 128).any(axis=1))


@pytest.mark.parametrize("letter", ["p", r"\omega", r"\psi"])
def test_a_dot_stands_above_its_letter(drawn, letter):
    bare = ink(drawn(letter))
    dotted = ink(drawn(rf"\dot {letter}"))
    assert np.ptp(dotted) > np.ptp(bare) + 0.05 * SIZE


def test_an_index_stands_beside_the_letter_that_has_a_dot(drawn):
    page = drawn(r"\dot p_t")
    letter, index = (page.locator("mi", has_text=name).bounding_box() for name in ("p", "t"))
    assert index["x"] >= letter["x"] + 0.9 * letter["width"]
    above, below = letter["y"], letter["y"] + letter["height"]
    assert above < index["y"] + 0.5 * index["height"] < below + 0.2 * SIZE


def test_bounds_of_a_sum_stay_where_they_are(converted):
    assert "munderover" in converted(r"\sum_{k=0}^{N} x_k", as_block=True)


def kinds(text):
    """Tags and texts of what a formula is made of, without the spaces between."""
    root = ElementTree.fromstring(text)
    return [(child.tag.partition("}")[2], (child.text or "").strip()) for child in root]


def test_the_name_of_a_function_stands_apart(converted):
    spaced = kinds(converted(r"v\cos\chi\sin(\psi)"))
    names = [text or tag for tag, text in spaced if text != "\u2061"]
    assert names == ["v", "mspace", "cos", "mspace", "χ", "mspace", "sin", "(", "ψ", ")"]


@pytest.mark.parametrize(
    ("formula", "forms"),
    [(r"+a - b", ["prefix", None]), (r"a = +b", ["prefix"]), (r"(a) + b", [None])],
)
def test_a_sign_belongs_to_what_follows_it(converted, formula, forms):
    root = ElementTree.fromstring(converted(formula))
    assert [mo.get("form") for mo in root if (mo.text or "").strip() in "+\u2212"] == forms
