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

"""Write the table of constants, ``docs/reference/constants.md``, from the code and its comments.

A constant is a name in capitals that a module gives a number, or a tuple, array or dictionary of
numbers. The comment behind it, or else the one above its block, begins with the unit, or with a
dash where there is none: ``# s for the first command``, ``# -, share of the rate``. The kind
follows from the unit and from words of the comment, see :data:`KINDS`; whole numbers without a
unit are counts.
"""

from __future__ import annotations

import ast
import io
import json
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from uav_tracking_mpc.report.pages import Table

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "uav_tracking_mpc"
PAGE = ROOT / "docs/reference/constants.md"
TRIED = ROOT / "docs/reference/constants_tried.json"  # written by test/constant_trial.py
WAYS = ("halved", "doubled")
UNTRIED = ("display", "code")  # nobody tunes a protocol or a layout
HEADINGS = (
    "constant", "module", "value", "unit", "kind", "what it is for", "source",
    "noticed when halved", "when doubled",
)  # fmt: skip
# An example of what is generated for each problem.
LEFT_OUT = re.compile(r"mpc/newton/stage\.py")
DISPLAY = re.compile(r"(view|report)/(?!metrics|bag).*|studies/.*(figures?|page)\.py")
# Patterns of the unit and of words of the comment for each kind; the first that fits decides.
KINDS = (
    ("code", "", r"\b([Cc]odes?|bits?|flags?|type_mask|[Ii]ndex|[Ii]ndices|[Cc]olumns)\b"),
    ("sensor noise", r"(?!m?s$|-).*", r"\b(noise|accuracy|standard deviations?)\b"),
    ("probability", "", r"\b(probability|confidence|p-value|quantiles)\b"),
    ("tolerance", "", r"\b(tolerance|rounding|smooth|relative|violation|iterate|pivot)\b"),
    ("physical", "", r"\b(standard(?! dev)|WGS 84|of dry air|international|convention)\b"),
    ("paper", "", r"\((28|58|59|60)\)|Table 1|Section 6"),
    ("time", r"m?s|ns|us|Hz", ""),
    ("gain", r"1/s.*|.* per .*", ""),
    ("weight", "-", r"\b(weights?|cost)\b"),
    ("ratio", "-", ""),
    ("count", r"bytes|baud", ""),
    ("bound", r".+", ""),
)
BASE = r"(?:rad|deg|kg|mm|ms|ns|us|Hz|inch|pixels?|bytes|baud|[mgsKJ])(?:\^\d)?"
ONE = rf"(?:-|(?:1/|1 per )?{BASE}(?:(?:/| per )\(?{BASE}(?: {BASE}\))?)*)"
UNIT = re.compile(rf"({ONE}(?:(?:, | and | or ){ONE})*)(?=[ ,:;.]|$)")
SOURCE = re.compile(
    r"\(\d\d\)|Table \d|Section \d|[\w/.*]+\.(?:cpp|hpp|h|c|yaml)\b|\b[A-Z]+\d?_[A-Z_\d]+\b"
    r"|MIL-[\w-]+|WGS 84|POSIX|documentation of .*|MAVLink guide, .*|3rd General .*"
)


@dataclass(frozen=True)
class Constant:
    """A number of a module with its comment, and which of the names of its statement it has."""

    path: str
    name: str
    value: ast.expr
    comment: str
    place: tuple[int, int]

    @property
    def key(self) -> str:
        """Module and name, as in the file of what was tried."""
        return f"{self.path} {self.name}"

    @cached_property
    def unit(self) -> str:
        """A dash for a pure number, nothing for what is counted and for codes."""
        found = UNIT.match(self.comment)
        units = re.split(", | and ", found[1]) if found else [""]
        place, names = self.place
        return units[place] if len(units) == names else found[1] if found else ""

    @cached_property
    def kind(self) -> str:
        """Nothing where neither unit nor words tell it."""
        if DISPLAY.fullmatch(self.path):
            return "display"
        for kind, unit, words in KINDS:
            if re.search(words, self.comment) and re.fullmatch(unit or ".*", self.unit):
                return kind
        leaves = [node.value for node in ast.walk(self.value) if isinstance(node, ast.Constant)]
        return "count" if self.comment and all(type(leaf) in (int, str) for leaf in leaves) else ""

    @property
    def source(self) -> str:
        """What the comment cites, or other constants that it follows from."""
        used = [node.id for node in ast.walk(self.value) if isinstance(node, ast.Name)]
        own = ", ".join(name for name in used if name.isupper())
        return ", ".join(SOURCE.findall(self.comment)) or (f"computed from {own}" if own else "")


def constants() -> Iterator[Constant]:
    """Those of the package."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name = str(path.relative_to(PACKAGE))
        if not LEFT_OUT.fullmatch(name):
            yield from of_source(name, path.read_text(encoding="utf-8"))


def of_source(path: str, code: str) -> Iterator[Constant]:
    """Those of a module."""
    comments, lines = {}, code.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(code).readline):
        if token.type == tokenize.COMMENT:
            words = re.sub(r"#\s*(fmt|type|noqa):.*", "", token.string)
            comments[token.start[0]] = words.lstrip("# ").strip()
    for node in ast.parse(code).body:
        for name, value, place in named(node):
            inside = [comments.get(k, "") for k in range(node.lineno, (node.end_lineno or 0) + 1)]
            above = node.lineno - 1
            while above and lines[above - 1] and lines[above - 1][0] != "#":
                above -= 1
            heading: list[str] = []
            while above and lines[above - 1].startswith("#"):
                heading.insert(0, comments[above])
                above -= 1
            comment = " ".join(filter(None, inside)) or " ".join(heading)
            yield Constant(path, name, value, comment, place)


def named(node: ast.stmt) -> Iterator[tuple[str, ast.expr, tuple[int, int]]]:
    """Names in capitals to which a statement gives numbers, each with its own and its place."""
    for target in getattr(node, "targets", [getattr(node, "target", None)]):
        value = getattr(node, "value", None)
        several = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
        pairs = list(zip(target.elts, value.elts, strict=True)) if several else [(target, value)]
        for k, (name, own) in enumerate(pairs):
            if isinstance(name, ast.Name) and name.id.isupper() and is_number(own):
                yield name.id, own, (k, len(pairs))


def is_number(node: ast.AST | None) -> bool:
    """Whether it is a number, or a tuple, list, dictionary or array of them."""
    if isinstance(node, ast.Constant):
        return type(node.value) in (int, float)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):  # the other may be a name
        return is_number(node.left) or is_number(node.right)
    if isinstance(node, (ast.Tuple, ast.List)):
        return bool(node.elts) and all(map(is_number, node.elts))
    if isinstance(node, ast.Dict):
        return bool(node.values) and all(map(is_number, node.values))
    called = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
    return called.startswith(("math.", "np.")) and any(map(is_number, node.args))


def noticed(constant: Constant, tried: dict[str, dict[str, str]]) -> list[str]:
    """The test that fails with half of it, and that with twice as much."""
    if constant.kind in UNTRIED:
        return ["", ""]
    said = tried.get(constant.key, dict.fromkeys(WAYS, "not run"))
    return [said[way] or "by no test of its file" for way in WAYS]


def table() -> Table:
    """A row for every constant."""
    tried, rows = json.loads(TRIED.read_text(encoding="utf-8")), []
    for own in constants():
        words = UNIT.sub("", own.comment, count=1) if own.unit else own.comment
        value = re.sub(r"\b(math|np)\.", "", ast.unparse(own.value))
        cells = [f"`{own.name}`", f"`{own.path}`", f"`{value}`", own.unit, own.kind]
        rows.append([*cells, words.lstrip(" ,:;."), own.source or "chosen", *noticed(own, tried)])
    return Table(HEADINGS, rows)


if __name__ == "__main__":
    table().write_into(PAGE, "constants")
