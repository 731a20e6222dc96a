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

"""Seeded mutants of the package: in each, an operator of cosmic-ray changes one statement.

Statements are ranked by a hash of their text and the seed. So each is as likely as another, and a
change of the package elsewhere leaves a sample as it is.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import hashlib
import random
import subprocess
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "uav_tracking_mpc"
# One operator stands for another of its group; across groups a mutant would only raise TypeError.
GROUPS = (
    {"Add", "Sub", "Mul", "Div", "FloorDiv", "Mod", "Pow"},
    {"BitOr", "BitAnd", "BitXor"},
    {"LShift", "RShift"},
    {"Eq", "NotEq", "Lt", "LtE", "Gt", "GtE"},
    {"Is", "IsNot"},
    {"UAdd", "USub", "Not", "Delete"},
)
# Without `compiled` or `cache` a function does the same; variables need names to take in exchange.
LEFT_OUT = ("RemoveDecorator", "VariableReplacer", "VariableInserter")
LOGGED = ("debug", "info", "warning", "warn", "error", "fatal", "exception")


@dataclass(frozen=True)
class Mutant:
    """One change of one statement; ``key`` is a digest of the whole file before and after it."""

    path: str
    line: int
    operator: str
    original: str
    code: str

    @property
    def key(self) -> str:
        return digest(self.path, self.original, self.code)[:16]

    @property
    def change(self) -> tuple[str, str]:
        """The changed lines before and after."""
        lines = list(difflib.ndiff(self.original.splitlines(), self.code.splitlines()))
        before, after = (" ".join(w[2:].strip() for w in lines if w[0] == sign) for sign in "-+")
        return before, after


def digest(*words: str) -> str:
    return hashlib.sha256("\0".join(words).encode()).hexdigest()


def git(*arguments: str) -> str:
    """What git prints in the checkout."""
    command = ["git", *arguments]
    return subprocess.run(command, cwd=ROOT, check=True, stdout=-1, text=True).stdout.strip()


def sample(seed: int, count: int) -> list[Mutant]:
    """The mutants of a seed.

    Raises:
        ValueError: The package has fewer statements that can be mutated.
    """
    ranked, operators, places, mutants = [], _operators(), {}, []
    for path in git("ls-files", f"{PACKAGE}/*.py").split():
        source, seen = (ROOT / path).read_text(encoding="utf-8"), Counter()
        for first, last in _statements(ast.parse(source)):
            text = "\n".join(source.splitlines()[first - 1 : last])
            seen[text] += 1
            rank = digest(str(seed), path, text, str(seen[text]))
            ranked.append((rank, path, source, first, last))
    for rank, path, source, first, last in sorted(ranked):
        if path not in places:
            places[path] = _mutations(source, operators)
        kinds = defaultdict(list)
        for name, occurrence in (m for k in range(first, last + 1) for m in places[path][k]):
            kinds[name.split("_")[0]].append((name, occurrence))
        if kinds:
            chosen = random.Random(rank)
            name, occurrence = chosen.choice(kinds[chosen.choice(sorted(kinds))])
            code = mutate_code(source, get_operator(name)(), occurrence)
            if _differs(source, code):
                mutants.append(Mutant(path, first, name.split("/")[1], source, code))
        if len(mutants) == count:
            return mutants
    raise ValueError(f"count must be at most {len(mutants)}, is {count}")


def _operators() -> list[str]:
    """Names of the operators that serve."""
    found = []
    for name in operator_names():
        pair = set(name.split("_")[1:])
        if any(pair <= group for group in GROUPS) and name.split("/")[1] not in LEFT_OUT:
            found.append(name)
    return found


def _statements(tree: ast.Module) -> Iterator[tuple[int, int]]:
    """First and last lines of statements: of a compound one without its body.

    What is imported, logged, or seen by type checkers alone is left out.
    """
    unseen = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if not isinstance(node, ast.stmt) or isinstance(node, (ast.Import, ast.ImportFrom)):
            continue
        called = node.value if isinstance(node, ast.Expr) else None
        logs = isinstance(called, ast.Call) and getattr(called.func, "attr", "") in LOGGED
        if logs or id(node) in unseen:
            continue
        inner = getattr(node, "body", None) or getattr(node, "cases", None)
        yield node.lineno, max(node.lineno, first_line(inner[0]) - 1) if inner else node.end_lineno


def first_line(node: ast.AST) -> int:
    """The line on which a statement begins, or the first of its decorators."""
    if isinstance(node, ast.match_case):
        return node.pattern.lineno
    return min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])


def _mutations(source: str, operators: list[str]) -> dict[int, list[tuple[str, int]]]:
    """Operators and which of their occurrences in the file, by line, without annotations."""
    notes = set()
    for node in ast.walk(ast.parse(source)):
        for note in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if isinstance(note, ast.expr):
                for line in range(note.lineno, note.end_lineno + 1):
                    begin = note.col_offset if line == note.lineno else 0
                    end = note.end_col_offset if line == note.end_lineno else 1000
                    notes |= {(line, column) for column in range(begin, end)}
    found, counts = defaultdict(list), Counter()
    made = [(name, get_operator(name)()) for name in operators]
    for node in ast_nodes(get_ast(source)):
        for name, operator in made:
            for place, _ in operator.mutation_positions(node):
                if place not in notes:
                    found[place[0]].append((name, counts[name]))
                counts[name] += 1
    return found


def _differs(source: str, code: str) -> bool:
    """Whether a mutant is a program, and another one."""
    with contextlib.suppress(SyntaxError):
        return "not not" not in code and ast.dump(ast.parse(code)) != ast.dump(ast.parse(source))
    return False
