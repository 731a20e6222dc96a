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

"""Every public function, method and class says what it takes: meaning, unit and shape.

An argument has an entry ``name: ...`` in ``Args:`` (of a constructor: in the class's docstring; of
a dataclass or NamedTuple: in ``Attributes:``), or a sentence of the docstring names it. A float
has its unit there, ``[m]``, ``[-]`` for a pure number; an array its shape, and so has an array that
comes back. A method that overrides another may say ``See :meth:`Base.method`.`` instead, and a
field that :func:`parameter` makes describes itself.
"""

from __future__ import annotations

import ast
import re
import textwrap
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "uav_tracking_mpc"
SOURCES = sorted(PACKAGE.rglob("*.py"))
ARRAY = re.compile(r"\b(NDArray|ArrayLike|ndarray)\b")
FLOAT = re.compile(r"(?<![\w.])float\b")
UNIT = re.compile(r"\[[^\]]+\]")
SHAPE = re.compile(r"\bshapes?\b|\bscalar\b", re.IGNORECASE)
SECTION = re.compile(r"^(Args|Attributes|Returns|Yields|Raises|Example|Examples|Note):\s*$")
ENTRY = re.compile(r"^\*{0,2}(\w+)( \([^)]*\))?: (.*)$")
REFERENCE = re.compile(r"\b[Ss]ee\s+:(?:meth|attr):`~?(?:[\w.]*\.)?(\w+)\.(\w+)`")
NUMBA = {"compiled", "entry", "intrinsic"}


def room(path):
    return path.relative_to(PACKAGE).parts[0]


def sections(docstring):
    """Text by section, "" for what stands before the first."""
    parts, current = {"": []}, ""
    for line in docstring.splitlines():
        found = SECTION.match(line)
        if found:
            current = found[1]
        elif line and not line[0].isspace() and current:
            current = ""
        parts.setdefault(current, []).append("" if found else line)
    return {name: textwrap.dedent("\n".join(lines)) for name, lines in parts.items()}


def entries(text):
    """Words of each ``name: ...`` of a section."""
    found, current = {}, None
    for line in text.splitlines():
        entry = ENTRY.match(line)
        if entry:
            current = entry[1]
            found[current] = entry[3]
        elif current is not None and line[:1].isspace():
            found[current] += " " + line.strip()
    return found


def sentences(text):
    return re.split(r"(?<=[.:;])\s+|\n\s*\n", text)


def needs(annotation):
    """What the words about a value of this type must hold."""
    words = "" if annotation is None else ast.unparse(annotation).strip("'\"")
    words = re.sub(r"Callable\[.*\]", "", words)
    if ARRAY.search(words):
        return [("shape", SHAPE)]
    return [("[unit]", UNIT)] if FLOAT.search(words) else []


def missing(name, annotation, documented, prose):
    """What is not said of an argument; None where nothing is missing."""
    if name in documented:
        lacking = [what for what, found in needs(annotation) if not found.search(documented[name])]
        return f"{name}: {' and '.join(lacking)}" if lacking else None
    named = [s for s in sentences(prose) if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", s)]
    for sentence in named:
        if all(found.search(sentence) for _, found in needs(annotation)):
            return None
    lacking = [what for what, _ in needs(annotation)]
    return f"{name}: {' and '.join(lacking)} where it is named" if named else f"{name}: no word"


def arguments(function):
    parts = function.args
    taken = [*parts.posonlyargs, *parts.args, *parts.kwonlyargs]
    taken += [part for part in (parts.vararg, parts.kwarg) if part is not None]
    return [
        (part.arg, part.annotation)
        for part in taken
        if part.arg not in ("self", "cls") and part.arg[0] != "_"
    ]


def decorators(node):
    return {
        ast.unparse(part.func if isinstance(part, ast.Call) else part).split(".")[-1]
        for part in node.decorator_list
    }


@cache
def methods():
    """(class, method) of every class of the package."""
    return {
        (node.name, part.name)
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
        for part in node.body
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef)
    }


def of_function(function, label):
    docstring = ast.get_docstring(function)
    if docstring is None:
        yield f"{label}: no docstring"
        return
    if any(found.groups() in methods() for found in REFERENCE.finditer(docstring)):
        return
    parts = sections(docstring)
    documented = entries(parts.get("Args", ""))
    rest = " ".join(text for name, text in parts.items() if name != "Args")
    taken = arguments(function)
    if "intrinsic" in decorators(function):
        taken = taken[1:]  # numba's typing context, which no caller gives
    for name, annotation in taken:
        lacking = missing(name, annotation, documented, parts[""])
        if lacking:
            yield f"{label}: {lacking}"
    for name in sorted(set(documented) - {name for name, _ in taken}):
        yield f"{label}: {name} is no argument"
    if ("shape", SHAPE) in needs(function.returns) and not SHAPE.search(rest):
        yield f"{label}: shape of what comes back"


def fields(node):
    """Annotated fields of a dataclass or NamedTuple that do not describe themselves."""
    bases = {ast.unparse(base).split(".")[-1] for base in node.bases}
    if "dataclass" not in decorators(node) and not bases & {"NamedTuple", "TypedDict"}:
        return []
    return [
        (part.target.id, part.annotation)
        for part in node.body
        if isinstance(part, ast.AnnAssign)
        and isinstance(part.target, ast.Name)
        and part.target.id[0] != "_"
        and "ClassVar" not in ast.unparse(part.annotation)
        and not (isinstance(part.value, ast.Call) and ast.unparse(part.value.func) == "parameter")
    ]


def of_class(node, label):
    docstring = ast.get_docstring(node)
    if docstring is None:
        yield f"{label}: no docstring"
        return
    parts = sections(docstring)
    expected = [(name, annotation, "Attributes") for name, annotation in fields(node)]
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and part.name == "__init__":
            expected += [(name, annotation, "Args") for name, annotation in arguments(part)]
    for name, annotation, section in expected:
        lacking = missing(name, annotation, entries(parts.get(section, "")), parts[""])
        if lacking:
            yield f"{label}: {lacking}"


def findings(body, prefix=""):
    for node in body:
        name = getattr(node, "name", "_")
        label = prefix + name
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            if name == "__call__" or (name[0] != "_" and "overload" not in decorators(node)):
                yield from of_function(node, label)
        elif isinstance(node, ast.ClassDef) and name[0] != "_":
            yield from of_class(node, label)
            yield from findings(node.body, f"{label}.")


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_arguments_units_and_shapes_are_documented(path):
    found = list(findings(ast.parse(path.read_text(encoding="utf-8")).body))
    assert not found, f"{path.relative_to(PACKAGE)}:\n  " + "\n  ".join(found)


SOURCE = '''
def good(distance: float, states: NDArray, name: str) -> NDArray:
    """Shape (n,), of a name.

    Args:
        distance: Ahead, in [m].
        states: Rows, shape (n, 3).
    """

def bad(distance: float, states: NDArray, name: str, share: float = 1.0) -> NDArray:
    """Something. A share of it.

    Args:
        distance: Ahead.
        states: Rows.
        other: Not there.
    """

def brief(angle: float) -> float:
    """Wrap ``angle`` [rad]."""

@dataclass
class Fields:
    """Two.

    Attributes:
        range: r in [m].
    """
    range: float
    speed: float
    gain: float = parameter(1.0, "described")

class Made:
    """Made of parts."""
    def __init__(self, mass: float) -> None: ...
    def step(self, time: float) -> None:
        """Advance."""
    def _private(self, time: float) -> None: ...
'''


def test_the_walk_finds_what_is_missing():
    assert list(findings(ast.parse(SOURCE).body)) == [
        "bad: distance: [unit]",
        "bad: states: shape",
        "bad: name: no word",
        "bad: share: [unit] where it is named",
        "bad: other is no argument",
        "bad: shape of what comes back",
        "Fields: speed: no word",
        "Made: mass: no word",
        "Made.step: time: no word",
    ]
