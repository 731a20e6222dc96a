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

"""Print the size of what git tracks: Python files, statements, tokens, lines of code, by room.

Docstrings and comments do not count; statements and tokens do not change with line breaks.
"""

from __future__ import annotations

import ast
import collections
import io
import subprocess
import tokenize
from pathlib import Path

LAYOUT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER,
}  # fmt: skip
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def size(source: str) -> tuple[int, int, int]:
    """Statements, tokens and lines of code of a source."""
    nodes = list(ast.walk(ast.parse(source)))
    docstrings = [
        node.body[0]
        for node in nodes
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node) is not None
    ]
    prose = {n for text in docstrings for n in range(text.lineno, text.end_lineno + 1)}
    tokens = [
        token
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type not in LAYOUT and token.start[0] not in prose
    ]
    lines = {n for token in tokens for n in range(token.start[0], token.end[0] + 1)}
    statements = sum(isinstance(node, ast.stmt) for node in nodes) - len(docstrings)
    return statements, len(tokens), len(lines)


def rooms(path: Path) -> list[str]:
    """The folders that a file counts for: the top one, and that of package and tests below it."""
    top, *below = path.parts[:-1] or (".",)
    return [top, f"{top}/{below[0]}"] if below and top in ("uav_tracking_mpc", "test") else [top]


def main() -> None:
    command = ["git", "ls-files", "-z", "*.py"]
    names = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    totals: dict[str, list[int]] = collections.defaultdict(lambda: [0, 0, 0, 0])
    for path in map(Path, filter(None, names.split("\0"))):
        counted = (1, *size(path.read_text(encoding="utf-8")))
        for room in rooms(path):
            totals[room] = [a + b for a, b in zip(totals[room], counted, strict=True)]
    print(f"{'':32}{'files':>8}{'statements':>12}{'tokens':>10}{'lines':>10}")
    for room, (files, statements, tokens, lines) in sorted(totals.items()):
        print(f"{room:32}{files:8}{statements:12}{tokens:10}{lines:10}")


if __name__ == "__main__":
    main()
