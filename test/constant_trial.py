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

"""Halve and double each constant of the package and ask the tests of its module.

::

    python test/constant_trial.py control limits laws

tries the constants of these rooms, at HEAD, in a copy of the checkout. The tests are those of the
file that mirrors the module, or of its folder where there is none, without nodes, browsers and long
forms. The first that fails goes into ``docs/reference/constants_tried.json``, from which ``make
docs`` makes the table of constants. A call goes on where an earlier one ended.
"""

from __future__ import annotations

import ast
import json
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from constants import TRIED, UNTRIED, WAYS, Constant, constants
from mutant_trial import KINDS, Copy
from mutants import PACKAGE, ROOT, Mutant, git

LEAST_TIME = 1200.0  # s, to compile a solver, and ten times what the tests took before


def scaled(node: ast.expr, way: str) -> ast.expr:
    """The expression of half of a number, or of twice as much, element by element."""
    if isinstance(node, (ast.Tuple, ast.List)):
        return type(node)([scaled(item, way) for item in node.elts], node.ctx)
    if isinstance(node, ast.Dict):
        return ast.Dict(node.keys, [scaled(item, way) for item in node.values])
    whole = all(type(n.value) is int for n in ast.walk(node) if isinstance(n, ast.Constant))
    operator = ast.Mult() if way == "doubled" else ast.FloorDiv() if whole else ast.Div()
    return ast.BinOp(node, operator, ast.Constant(2))


def mutant(constant: Constant, way: str) -> Mutant:
    """The module with a constant halved or doubled."""
    path, node = f"{PACKAGE}/{constant.path}", constant.value
    lines = (ROOT / path).read_text(encoding="utf-8").splitlines(keepends=True)
    begin = sum(map(len, lines[: node.lineno - 1])) + node.col_offset
    end = sum(map(len, lines[: node.end_lineno - 1])) + node.end_col_offset
    code = "".join(lines)
    value = f"({ast.unparse(scaled(node, way))})"
    return Mutant(path, node.lineno, way, code, code[:begin] + value + code[end:])


def tests_of(path: str) -> str:
    """The test file of a module, or the folder of its room."""
    file = ROOT / "test" / path
    own = file.with_name(f"test_{file.name.lstrip('_')}")
    found = own if own.exists() else next(folder for folder in file.parents if folder.is_dir())
    return str(found.relative_to(ROOT))


def tried(rooms: list[str], known: dict) -> Iterator[tuple[str, dict[str, str]]]:
    """Constants of these rooms that are not known, with the first test that fails either way."""
    every = [c for c in constants() if c.kind not in UNTRIED and c.key not in known]
    wanted = [c for room in rooms for c in every if c.path.startswith(f"{room}/")]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        copy, limits = Copy(Path(folder), "HEAD"), {}
        for constant in wanted:
            tests = [*KINDS["unit"], "-x", tests_of(constant.path)]
            if tests[-1] not in limits:
                begin = time.monotonic()
                failed = copy.pytest(tests, copy.cache, 3600.0)
                limits[tests[-1]] = LEAST_TIME + 10.0 * (time.monotonic() - begin)
                if failed:
                    raise SystemExit(f"{failed} fails as it is")
            said = {}
            for way in WAYS:
                changed = mutant(constant, way)
                copy.write(changed.path, changed.code)
                said[way] = copy.pytest(tests, copy.cache, limits[tests[-1]]).split("[")[0]
                copy.write(changed.path, changed.original)
            yield constant.key, said


if __name__ == "__main__":
    if git("status", "--porcelain", PACKAGE):
        raise SystemExit(f"all changes of {PACKAGE} must be committed")
    known = json.loads(TRIED.read_text(encoding="utf-8"))
    for key, said in tried(sys.argv[1:], known):
        known[key] = {way: name.removeprefix("test/") for way, name in said.items()}
        lines = (f"{json.dumps(key)}: {json.dumps(known[key])}" for key in sorted(known))
        TRIED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
        print(key, *known[key].values(), sep="\n  ", flush=True)
