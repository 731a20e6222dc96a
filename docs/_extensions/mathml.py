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

"""Mathematics as MathML, which browsers draw themselves.

The pages then need no script, no font and no network. The conversion is that of docutils; a formula
that it does not know is a warning, and so ends the build.

Five things are corrected. For a letter with an accent and an index, docutils puts the index under
the letter. What is marked as an accent is drawn by Chromium into the letter if no font of the
machine is a mathematical one, and a dot is then not seen. Names of functions stand without space
between their neighbours. A sign at the beginning, and the bars of a norm, are spaced like a sum.
"""

import html
import re
import xml.etree.ElementTree as ET

from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml

MATHML = "http://www.w3.org/1998/Math/MathML"
ET.register_namespace("", MATHML)
THIN = "0.167em"
APPLIED = "\u2061"  # invisible, after the name of a function
SIGNS, CLOSING = ("+", "\u2212", "\u00b1"), (")", "]", "}", "|", "\u2016", "!")
BARS = ("|", "\u2016")
HTML_ENTITY = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#\w+);)\w+;")  # XML knows five alone


def setup(app):
    """Register the renderer ``mathml`` for HTML."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def visit_math(translator, node):
    """Write a formula within a line, and skip what is inside the node."""
    translator.body.append(mathml(node, as_block=False))
    raise_skip()


def visit_math_block(translator, node):
    """Write a formula that stands by itself."""
    translator.body.append(f'<div class="math">{mathml(node, as_block=True)}</div>\n')
    raise_skip()


def mathml(node, as_block):
    """Formula of a node."""
    try:
        return converted(node.astext(), as_block=as_block)
    except MathError as error:
        from sphinx.util import logging

        logger = logging.getLogger(__name__)
        logger.warning("formula %r: %s", node.astext(), error, location=node)
        return f"<code>{node.astext()}</code>"


def converted(formula, as_block=False):
    """MathML of a formula.

    Raises MathError where docutils does not know it.
    """
    text = tex2mathml(formula, as_block=as_block)
    root = ET.fromstring(HTML_ENTITY.sub(lambda found: html.unescape(found[0]), text))
    for over in [*root.iter(f"{{{MATHML}}}mover"), *root.iter(f"{{{MATHML}}}munderover")]:
        over.attrib.pop("accent", None)
        if over.tag.endswith("munderover") and over[2].get("stretchy") == "false":
            base, index, accent = over
            over.tag = f"{{{MATHML}}}msub"
            over[:] = [ET.Element(f"{{{MATHML}}}mover"), index]
            over[0].extend([base, accent])
    for row in list(root.iter()):
        _space(row)
    return ET.tostring(root, encoding="unicode")


def _space(row):
    """Set functions apart from their neighbours, and signs next to what they belong to."""
    before = None
    for element in list(row):
        text = (element.text or "").strip() if element.tag == f"{{{MATHML}}}mo" else None
        follows_operand = before is not None and before in ("", *CLOSING)
        if text == APPLIED:
            at = list(row).index(element)
            if at >= 2 and _is_operand(row[at - 2]):
                row.insert(at - 1, _thin_space())
            if (at := list(row).index(element)) + 1 < len(row) and row[at + 1].text != "(":
                row.insert(at + 1, _thin_space())
        elif text in SIGNS and not follows_operand:
            element.set("form", "prefix")
        elif text in BARS:
            element.set("lspace", "0")
            element.set("rspace", "0")
        before = "" if text is None else text


def _is_operand(element):
    """Whether an element is no operator, or closes a bracket."""
    return element.tag != f"{{{MATHML}}}mo" or (element.text or "").strip() in CLOSING


def _thin_space():
    return ET.Element(f"{{{MATHML}}}mspace", width=THIN)


def raise_skip():
    """Leave the node: its text is already written."""
    from docutils import nodes

    raise nodes.SkipNode
