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

Two things of it are mended. Of a letter with an accent and an index it makes one with the index
under it. And what it marks as an accent is drawn by Chromium into the letter where no font of the
machine tells how high letters are, as mathematical fonts do; a dot is then not seen.
"""

import html
import re
import xml.etree.ElementTree as ET

from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml

MATHML = "http://www.w3.org/1998/Math/MathML"
ET.register_namespace("", MATHML)
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
    return ET.tostring(root, encoding="unicode")


def raise_skip():
    """Leave the node: its text is already written."""
    from docutils import nodes

    raise nodes.SkipNode
