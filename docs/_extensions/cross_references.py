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
meant, if there is one such thing in the package. A reference that leads nowhere ends the build.
Types in signatures may be of other packages, which have no page here.
"""

import re
from collections import defaultdict
from importlib import import_module
from importlib.util import find_spec

from docutils.parsers.rst.states import Inliner
from sphinx.util.nodes import make_refnode

PACKAGE = "uav_tracking_mpc"
ARRAY = re.compile(
    r"~?numpy\.ndarray\[~?(?:tuple\[~?typing\.Any, \.\.\.\]|typing\.Any), "
    r"~?numpy\.dtype\[~?(?:numpy\.)?(\w+)\]\]"
)
WORDS: dict[str, list[str]] = defaultdict(list)
PLAIN = ("attribute", "data", "property")


def setup(app):
    """Connect to the reading of docstrings and the search for targets."""
    app.connect("autodoc-process-docstring", keep_first_line, priority=400)  # before napoleon
    app.connect("autodoc-process-signature", name_arrays)
    app.connect("autodoc-skip-member", skip_private)
    app.connect("missing-reference", resolve)
    Inliner.dispatch["|"] = bar
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def bar(inliner, match, line):
    """|x| is a magnitude here, and never a substitution."""
    end = match.end("start")
    return match.string[:end], [], match.string[end:], []


def keep_first_line(app, what, name, value, options, lines):
    """What stands before a colon in the first line of an attribute is text, not its type."""
    if what in PLAIN:
        lines.insert(0, "")


def name_arrays(app, what, name, value, options, signature, returned):
    """Write ``NDArray[float64]`` instead of what numpy makes of it."""
    return tuple(text and ARRAY.sub(r"NDArray[\1]", text) for text in (signature, returned))


def skip_private(app, what, name, value, skip, options):
    """Private modules are shown, their private members are not."""
    return True if name.startswith("_") else None


def resolve(app, environment, node, content):
    """Find the one object of the package whose path ends in the reference's target."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].lstrip(".~").removeprefix(f"{PACKAGE}.")
    domain = environment.domains.python_domain
    objects, kinds = domain.objects, domain.objtypes_for_role(node["reftype"]) or []
    if "method" in kinds:
        kinds = [*kinds, "property"]  # the base's method may be a property
    found = [
        full
        for full in of_last_word(objects).get(target.rpartition(".")[2], ())
        if full.endswith(f".{target}") and objects[full].objtype in kinds
    ]
    if len(found) > 1:  # prefer where the package's own text looks: the same module
        found = [full for full in found if full.startswith(f"{node.get('py:module')}.")]
    if not found and node.get("reftype") == "data":
        found = constant(node["reftarget"], node.get("py:module"))
    if len(found) == 1:
        entry = objects[found[0]]
        return make_refnode(
            app.builder, node["refdoc"], entry.docname, entry.node_id, content, found[0]
        )
    written_by_hand = "refwarn" in node
    elsewhere = "." in target and find_spec(target.partition(".")[0]) is not None
    return None if written_by_hand and not elsewhere else content


def of_last_word(objects):
    """Names of the package by their last word; made once, when all documents have been read."""
    if not WORDS:
        for name in objects:
            WORDS[name.rpartition(".")[2]].append(name)
    return WORDS


def constant(target, module):
    """Module that holds a constant; constants have no entry of their own."""
    path, _, name = target.lstrip("~.").rpartition(".")
    path = path or module
    return [path] if path and hasattr(import_module(path), name) else []
