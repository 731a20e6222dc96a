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

"""What docstrings mean, where plain Sphinx would take it for something else.

A docstring says ``:meth:`GuidanceLaw.inputs```, not the whole path: what ends in that name is
meant, if the reference pages have one such thing. Other names of the package, and types of other
packages, are shown without a link. A name that nothing in the package has ends the build, also in
a docstring that no page shows.
"""

import ast
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from docutils.parsers.rst.states import Inliner
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

import uav_tracking_mpc

PACKAGE = "uav_tracking_mpc"
ARRAY = re.compile(
    r"~?numpy\.ndarray\[~?(?:tuple\[~?typing\.Any, \.\.\.\]|typing\.Any), "
    r"~?numpy\.dtype\[~?(?:numpy\.)?(\w+)\]\]"
)
LIKE = re.compile(r"~?\S*_Buffer \|.*?_NestedSequence\[~?complex \| ~?bytes \| ~?str\]")
SOURCES = sorted(Path(uav_tracking_mpc.__file__).parent.rglob("*.py"))
REFERENCE = re.compile(r":(?:attr|class|const|data|exc|func|meth|mod|obj):`[~.]*([\w.]+)`")
PLAIN = ("attribute", "data", "property")


def setup(app):
    """Connect to the reading of docstrings and the search for targets."""
    app.connect("builder-inited", check_sources)
    app.connect("autodoc-process-docstring", keep_first_line, priority=400)  # before napoleon
    app.connect("autodoc-process-signature", name_arrays)
    app.connect("autodoc-skip-member", skip_private)
    app.connect("missing-reference", resolve)
    Inliner.dispatch["|"] = bar
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def check_sources(app):
    """Warn of every reference of the package's docstrings that leads nowhere."""
    for path in SOURCES:
        for target in REFERENCE.findall(path.read_text(encoding="utf-8")):
            if not is_somewhere(target):
                logging.getLogger(__name__).warning("reference: %r", target, location=str(path))


def is_somewhere(target):
    """Whether the package defines a name, or another package is named."""
    start, _, rest = target.partition(".")
    return target.rpartition(".")[2] in names() or bool(rest and find_spec(start))


def bar(inliner, match, line):
    """|x| is a magnitude here, and never a substitution."""
    end = match.end("start")
    return match.string[:end], [], match.string[end:], []


def keep_first_line(app, what, name, value, options, lines):
    """What stands before a colon in the first line of an attribute is text, not its type."""
    if what in PLAIN:
        lines.insert(0, "")


def name_arrays(app, what, name, value, options, signature, returned):
    """Write ``NDArray[float64]`` instead of what numpy makes of it, and ``...`` for a factory."""
    texts = [text and ARRAY.sub(r"NDArray[\1]", text) for text in (signature, returned)]
    return tuple(text and LIKE.sub("ArrayLike", text).replace("<factory>", "...") for text in texts)


def skip_private(app, what, name, value, skip, options):
    """Leave private members out, whatever they document."""
    return True if name.startswith("_") else None


def resolve(app, environment, node, content):
    """Find the one thing on the reference pages whose path ends in the reference's target."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].lstrip(".~")
    name = target.rpartition(".")[2]
    objects = environment.domains.python_domain.objects
    wanted = (f".{target}", *([f"{PACKAGE}.{name}"] if name in uav_tracking_mpc.__all__ else ()))
    found = [full for full in objects if f".{full}".endswith(wanted)]
    if len(found) == 1:
        entry = objects[found[0]]
        return make_refnode(
            app.builder, node["refdoc"], entry.docname, entry.node_id, content, found[0]
        )
    written_by_hand = "refwarn" in node
    return content if is_somewhere(target) or not written_by_hand else None


@cache
def names():
    """Names that the package's sources define, and those of its modules."""
    found = {part for path in SOURCES for part in (path.stem, path.parent.name)}
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                found.add(node.name)
            elif isinstance(getattr(node, "ctx", None), ast.Store):
                found.add(getattr(node, "id", getattr(node, "attr", "")))
    return found
