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

"""What users import says in which units and shapes it takes its numbers; no docstring is stale.

That public things have docstrings is ruff's to see. An ``Args:`` list is needed only for what types
and names do not say: of the front door each float has its unit where it is described, ``[m]``,
``[-]`` for a pure number, and each array its shape, also one that comes back. The description is
the entry ``name: ...``, or a sentence that names it. A parameter that :func:`parameter` makes
describes itself. Entries of arguments that there are no more are found in the whole package.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import pydoc
import re
from pathlib import Path

import pytest
from numpy.typing import NDArray

import uav_tracking_mpc

PACKAGE = Path(uav_tracking_mpc.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
NEEDED = {
    re.compile(r"\b(NDArray|ArrayLike|ndarray)\b"): (
        "shape",
        re.compile(r"\bshapes?\b|\bscalar\b"),
    ),
    re.compile(r"(?<![\w.])float\b"): ("[unit]", re.compile(r"\[[^\]]+\]")),
}
ENTRY = re.compile(r"^ {4}\*{0,2}(\w+)(?: \([^)]*\))?: (.*(?:\n {5,}.*)*)", re.MULTILINE)
REFERENCE = re.compile(r"[Ss]ee :meth:`~?(uav_tracking_mpc[\w.]+)`")
LIST = re.compile(r"^(?:Args|Attributes):\n((?:(?: .*)?\n?)*)", re.MULTILINE)


def entries(docstring):
    """Words of each ``name: ...`` of the lists of a docstring."""
    return {
        name: words for block in LIST.findall(docstring) for name, words in ENTRY.findall(block)
    }


def lacks(annotation, words):
    """What words about a value of a type must hold and do not."""
    kind = re.sub(r"Callable\[.*\]", "", str(annotation))
    for type_, (what, sign) in NEEDED.items():
        if type_.search(kind):
            return "" if any(sign.search(each) for each in words) else what
    return ""


def undescribed(label, thing, docstring):
    """Parameters, and what comes back, of which no unit or shape is told."""
    described, signature = entries(docstring), inspect.signature(thing)
    sentences = re.split(r"(?<=[.:;])\s+|\n\s*\n", LIST.sub("", docstring))
    fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
    themselves = {field.name for field in fields if field.metadata}
    for name, parameter in signature.parameters.items():
        about = described.get(name)
        named = [each for each in sentences if re.search(rf"(?<!\w){name}(?!\w)", each)]
        what = lacks(parameter.annotation, named if about is None else [about])
        if what and name not in themselves:
            yield f"{label}: {name}: {what}"
    if lacks(signature.return_annotation, [docstring]) == "shape":
        yield f"{label}: shape of what comes back"


def told(method):
    """The docstring of a method, or of the one that it refers to."""
    text = inspect.getdoc(method) or ""
    found = REFERENCE.search(text)
    return inspect.getdoc(pydoc.locate(found[1])) if found else text


def findings(label, thing):
    """Of a function, or of a class and its methods."""
    if not inspect.isclass(thing):
        return undescribed(label, thing, inspect.getdoc(thing) or "")
    made = [] if issubclass(thing, Exception) else undescribed(label, thing, inspect.getdoc(thing))
    methods = [
        (name, method)
        for name, method in inspect.getmembers(thing, inspect.isfunction)
        if name[0] != "_" and method.__module__.split(".")[0] == thing.__module__.split(".")[0]
    ]
    return [*made, *(f for name, m in methods for f in undescribed(f"{label}.{name}", m, told(m)))]


@pytest.mark.parametrize("name", [name for name in uav_tracking_mpc.__all__ if name[0] != "_"])
def test_the_front_door_tells_units_and_shapes(name):
    assert list(findings(name, getattr(uav_tracking_mpc, name))) == []


def stale(tree):
    """Entries of functions whose arguments have other names."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            taken = {part.arg for part in ast.walk(node.args) if isinstance(part, ast.arg)}
            for name in sorted(set(entries(ast.get_docstring(node) or "")) - taken):
                yield f"{node.name}: {name} is no argument"


def test_what_is_described_is_an_argument():
    found = {path: list(stale(ast.parse(path.read_text(encoding="utf-8")))) for path in SOURCES}
    assert {path: words for path, words in found.items() if words} == {}


def good(distance: float, states: NDArray, name: str) -> NDArray:
    """Shape (n,), of a name.

    Args:
        distance: Ahead,
            in [m].
        states: Rows, shape (n, 3).
    """


def bad(distance: float, states: NDArray, name: str, share: float = 1.0) -> NDArray:
    """Something. A share of it.

    Args:
        distance: Ahead.
        states: Rows.
        other: Not there.
    """


@dataclasses.dataclass
class Fields:
    """Two.

    Attributes:
        range: r in [m].
    """

    range: float
    speed: float
    gain: float = dataclasses.field(default=1.0, metadata={"described": True})

    def step(self, time: float) -> None:
        """Advance."""


def test_what_is_missing_is_found():
    assert list(findings("good", good)) == []
    assert list(findings("bad", bad)) == [
        "bad: distance: [unit]",
        "bad: states: shape",
        "bad: share: [unit]",
        "bad: shape of what comes back",
    ]
    assert list(findings("Fields", Fields)) == [
        "Fields: speed: [unit]",
        "Fields.step: time: [unit]",
    ]
    source = Path(__file__).read_text(encoding="utf-8")
    assert list(stale(ast.parse(source))) == ["bad: other is no argument"]
