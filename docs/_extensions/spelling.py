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

"""Spelling of the pages: words of English, spelt the British way, and those of the glossary.

The dictionary of pyspellchecker is American. A word passes if it stands there, or its American form
does, or if it stands on the glossary's page; an American form does not pass. Code, formulas and
words with capitals inside are not checked.
"""

import re
from functools import cache
from pathlib import Path

from docutils import nodes
from spellchecker import SpellChecker
from sphinx import addnodes
from sphinx.util import logging

GLOSSARY = Path(__file__).parents[1] / "reference" / "words.md"
WORD = re.compile(r"(?<![\w./@-])[A-Za-z][a-z]+(?![\w/@]|\.\w)")
FORMS = {
    "is": "iz", "ys": "yz", "our": "or", "tre": "ter", "ogue": "og", "ence": "ense",
    "lled": "led", "lling": "ling", "ller": "ler",
}  # fmt: skip
AMERICAN = re.compile(
    r"(?!(?:re)?siz|priz|seiz)\w{2,}iz(?:e[drs]?|ers|ing|ations?)$|analyz"
    r"|.*(?:color|center|behavior|favor|neighbor)|(?:kilo|milli)?meters?$"
    r"|.*(?:model|label|level|travel|cancel)(?:ed|ing)$"
)
NOT_CHECKED = (
    nodes.FixedTextElement, nodes.literal, nodes.math, nodes.math_block, addnodes.desc_signature,
    addnodes.literal_emphasis, addnodes.literal_strong,
)  # fmt: skip
LOGGER = logging.getLogger(__name__)


def setup(app):
    """Check each page when it has been read."""
    app.connect("doctree-read", check)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def check(app, doctree):
    """Warn of every word that nobody knows."""
    for text in doctree.findall(nodes.Text):
        if not any(isinstance(node, NOT_CHECKED) for node in ancestors(text)):
            for word in WORD.findall(text):
                if not is_known(word.lower()):
                    LOGGER.warning("spelling: %r", word, location=text.parent)


def ancestors(node):
    """What a node stands in, from the inside out."""
    while node := node.parent:
        yield node


@cache
def is_known(word):
    """Whether a word in small letters is English in British spelling, or of the glossary."""
    if AMERICAN.match(word):
        return False
    american = [word.replace(*form) for form in FORMS.items() if form[0] in word]
    forms = (word, word.removesuffix("s"), *american)
    return any(form in english() or form in glossary() for form in forms)


@cache
def english():
    """Return the dictionary."""
    return SpellChecker(distance=1)


@cache
def glossary():
    """Words that the glossary explains or lists, small."""
    text = GLOSSARY.read_text(encoding="utf-8")
    explained = re.findall(r"^\| (.*?) \|", text, re.MULTILINE)
    listed = text.partition("## Other words")[2]
    return {word.lower() for word in WORD.findall(" ".join([*explained, listed]))}
