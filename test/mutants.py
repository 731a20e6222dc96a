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

"""Make seeded mutants of the package and let the tests of two revisions judge them.

::

    python test/mutants.py --tests HEAD --against 5f647f0

fails where a mutant survives the tests of the first revision that the tests of the second find. The
package is that of HEAD; a suite is ``test/`` and ``pyproject.toml`` of its revision.

The mutations are cosmic-ray's. Statements are ranked by a hash of their text, so that a change of the
package elsewhere leaves the sample as it is. A mutant meets, in a copy of the checkout with a copy of
the environment and of the cache of compiled solvers, the test file of its module, those of its folder,
then every test file that runs its function (or loads its module, where the mutant is no part of a
function or numba compiles it), processes and browsers last; a first run of each file on the unmutated
copy tells which files those are. A test finds a mutant if it fails on it, or does not end, and passes
on the unmutated copy. Verdicts go to ``results.json`` as they come, and are not asked for again.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import hashlib
import importlib.util
import json
import os
import queue
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "uav_tracking_mpc"
LEVELS = ("near", "unit", "all")  # the module's folder; all without processes; everything
KINDS = {
    "unit": ["-m", "not nodes and not browser and not long"],
    "nodes": ["-m", "nodes and not long", "--reruns=1"],
    "browser": ["-m", "browser and not long", "--reruns=1"],
}
# One operator stands for another of its group; across groups a mutant would only raise TypeError.
# Decorators stay (without `compiled` or `cache` a function does the same), names stay too.
GROUPS = ("Add Sub Mul Div FloorDiv Mod Pow", "BitOr BitAnd BitXor", "LShift RShift", "Is IsNot")
GROUPS += ("Eq NotEq Lt LtE Gt GtE", "UAdd USub Not Delete")
LEFT_OUT = ("RemoveDecorator", "VariableReplacer", "VariableInserter")
LOGGED = ("debug", "info", "warning", "warn", "error", "fatal", "exception")
COMPILED = ("compiled", "placed", "entry", "njit")
FILES_AT_ONCE = 20
PROBE = """
from pathlib import Path
seen = set()
def reached(key):
    if key not in seen:
        seen.add(key)
        with Path(__file__).with_name("reached.txt").open("a") as file:
            file.write(key + "\\n")
"""
GENEROUS = 600.0  # seconds, to which comes ten times what the files took unmutated


@dataclass(frozen=True)
class Mutant:
    """One change of one statement; ``key`` is a digest of the whole file before and after it."""

    path: str
    line: int
    operator: str
    code: str

    def original(self) -> str:
        return (ROOT / self.path).read_text(encoding="utf-8")

    @property
    def key(self) -> str:
        return digest(self.path, self.original(), self.code)[:16]

    @property
    def change(self) -> str:
        lines = difflib.ndiff(self.original().splitlines(), self.code.splitlines())
        return " ".join(line[0] + line[1:].strip() for line in lines if line[0] in "+-")


def digest(*words: str) -> str:
    return hashlib.sha256("\0".join(words).encode()).hexdigest()


def git(*arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout.strip()


def possible_operators() -> list[str]:
    """Names of cosmic-ray's operators that make a program which differs in what it does."""
    found = []
    for name in operator_names():
        pair = set(name.split("_")[1:])
        grouped = not pair or any(pair <= set(group.split()) for group in GROUPS)
        if grouped and name.split("/")[1] not in LEFT_OUT:
            found.append(name)
    return found


def statements(tree: ast.Module):
    """Statements of a module, each with its first and last line: a compound one without its body."""
    typing = [node for node in ast.walk(tree) if isinstance(node, ast.If)]
    typing = [node for node in typing if "TYPE_CHECKING" in ast.unparse(node.test)]
    unseen = {id(inner) for node in typing for inner in ast.walk(node)}
    for node in ast.walk(tree):
        if not isinstance(node, ast.stmt) or isinstance(node, (ast.Import, ast.ImportFrom)):
            continue
        called = node.value.func if isinstance(getattr(node, "value", 0), ast.Call) else None
        logs = isinstance(called, ast.Attribute) and called.attr in LOGGED
        if id(node) in unseen or (logs and isinstance(node, ast.Expr)):
            continue
        body = getattr(node, "body", None) or getattr(node, "cases", None)
        first = body and min([body[0].lineno, *(d.lineno for d in decorators(body[0]))])
        yield node.lineno, max(node.lineno, first - 1) if body else node.end_lineno


def decorators(node: ast.AST) -> list:
    return getattr(node, "decorator_list", [])


def annotated(tree: ast.Module) -> set[tuple[int, int]]:
    """Places (line, column) of all that stands in annotations."""
    found = set()
    for node in ast.walk(tree):
        for note in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            for inner in ast.walk(note) if note else ():
                if isinstance(inner, ast.expr):
                    found |= {
                        (inner.lineno, k) for k in range(inner.col_offset, inner.end_col_offset)
                    }
    return found


def mutations(source: str, operators: list[str]) -> dict[int, list[tuple[str, int]]]:
    """Operators and which of their occurrences in the file, by line, without annotations."""
    notes, counts, found = annotated(ast.parse(source)), dict.fromkeys(operators, 0), {}
    made = [(name, get_operator(name)()) for name in operators]
    for node in ast_nodes(get_ast(source)):
        for name, operator in made:
            for (line, column), _ in operator.mutation_positions(node):
                if (line, column) not in notes:
                    found.setdefault(line, []).append((name, counts[name]))
                counts[name] += 1
    return found


def sample(seed: int, count: int) -> list[Mutant]:
    """The mutants of a seed: one of a statement, each statement of the package as likely."""
    ranked, operators, places, mutants = [], possible_operators(), {}, []
    for file in git("ls-files", f"{PACKAGE}/*.py").split():
        source, seen = (ROOT / file).read_text(encoding="utf-8"), {}
        for first, last in statements(ast.parse(source)):
            text = "\n".join(source.splitlines()[first - 1 : last])
            seen[text] = seen.get(text, 0) + 1
            ranked.append((digest(str(seed), file, text, str(seen[text])), file, first, last))
    for rank, file, first, last in sorted(ranked):
        source = (ROOT / file).read_text(encoding="utf-8")
        if file not in places:
            places[file] = mutations(source, operators)
        kinds = {}
        for name, occurrence in (
            m for k in range(first, last + 1) for m in places[file].get(k, ())
        ):
            kinds.setdefault(name.split("_")[0], []).append((name, occurrence))
        if not kinds:
            continue
        chosen = random.Random(rank)
        name, occurrence = chosen.choice(kinds[chosen.choice(sorted(kinds))])
        code = mutate_code(source, get_operator(name)(), occurrence)
        with contextlib.suppress(SyntaxError):
            if "not not" not in code and ast.dump(ast.parse(code)) != ast.dump(ast.parse(source)):
                mutants.append(Mutant(file, first, name.split("/")[1], code))
        if len(mutants) == count:
            return mutants
    raise ValueError(f"count must be at most {len(mutants)}, is {count}")


def with_probes(source: str, mutants: list[Mutant]) -> str:
    """The module, telling which of its mutants' functions ran: mutants with a place of their own."""
    lines, marks = source.splitlines(), []
    for mutant in mutants:
        call = f'__import__("mutant_probe").reached("{mutant.key}")'
        inside = [
            node
            for node in ast.walk(ast.parse(source))
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
            and node.body[0].lineno <= mutant.line <= (node.end_lineno or 0)
            and node.body[0].lineno > node.lineno
        ]
        numba = any(ast.unparse(d) in COMPILED for node in inside for d in node.decorator_list)
        if not inside or numba:
            marks.append((len(lines), call))
            continue
        body = max(inside, key=lambda node: node.lineno).body
        start = body[len(body) > 1 and ast.get_docstring(ast.Module(body, [])) is not None]
        first = min([start.lineno, *(d.lineno for d in decorators(start))])
        marks.append((first - 1, " " * start.col_offset + call))
    for place, call in sorted(marks, reverse=True):
        lines.insert(place, call)
    return "\n".join(lines) + "\n"


class Copy:
    """A checkout of HEAD with the tests of one revision, in which the package can be mutated."""

    def __init__(self, folder: Path, tests: str) -> None:
        """Build it in ``folder`` with a linked copy of this environment, and try both."""
        self.root, self.cache = folder / "checkout", folder / "cache"
        self.root.mkdir(parents=True)
        for revision, paths in (("HEAD", []), (tests, ["test", "pyproject.toml"])):
            shutil.rmtree(self.root / "test", ignore_errors=True)
            packed = subprocess.Popen(
                ["git", "archive", revision, *paths], cwd=ROOT, stdout=subprocess.PIPE
            )
            subprocess.run(["tar", "-x"], cwd=self.root, stdin=packed.stdout, check=True)
            if packed.wait():
                raise SystemExit(f"git archive {revision} failed")
        self._copy_environment()
        self.caches = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        (self.cache / PACKAGE).mkdir(parents=True)
        self.link_caches(self.cache, self.caches / PACKAGE)
        tried = subprocess.run(
            [self.python, "-c", f"import {PACKAGE}; print({PACKAGE}.__file__)"],
            **self.place(self.cache), text=True, stdout=subprocess.PIPE,
        )  # fmt: skip
        if tried.stdout.strip() != str(self.root / PACKAGE / "__init__.py"):
            raise SystemExit(f"{self.python} imports the package of {tried.stdout.strip()!r}")

    def _copy_environment(self) -> None:
        def link(source: str, target: str) -> None:
            try:
                os.link(source, target)
            except OSError:
                shutil.copy2(source, target)

        environment = self.root / ".venv"
        shutil.copytree(ROOT / ".venv", environment, symlinks=True, copy_function=link)
        self.python = str(environment / "bin/python")
        (site,) = environment.glob("lib/python*/site-packages")
        for file in [*environment.glob("bin/*"), *site.glob("*.pth"), *site.glob("__editable__*.py")]:
            content = file.read_bytes() if file.is_file() and not file.is_symlink() else b""
            if os.fsencode(ROOT) in content:
                mode = file.stat().st_mode
                file.unlink()  # a link: the original keeps its content
                file.write_bytes(content.replace(os.fsencode(ROOT), os.fsencode(self.root)))
                file.chmod(mode)
        for compiled in site.glob("__pycache__/__editable__*"):
            compiled.unlink()
        self.reached = site / "reached.txt"
        (site / "mutant_probe.py").write_text(PROBE)

    def link_caches(self, cache: Path, solvers: Path) -> None:
        """Fill a folder for ``XDG_CACHE_HOME``: solvers are copied, the rest is the user's."""
        if solvers.is_dir():
            shutil.copytree(solvers, cache / PACKAGE, dirs_exist_ok=True)
        for other in self.caches.iterdir() if self.caches.is_dir() else ():
            if other.name != PACKAGE:
                (cache / other.name).symlink_to(other)

    def place(self, cache: Path) -> dict:
        """Where a process of this copy runs, as arguments of subprocess."""
        kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
        path = os.pathsep.join([str(self.root / ".venv/bin"), kept.get("PATH", "")])
        changed = {"PATH": path, "XDG_CACHE_HOME": str(cache), "ROS_PYTHON_CHECK_FIELDS": "1"}
        return {"cwd": self.root, "env": kept | changed}

    def write(self, path: str, code: str) -> None:
        """Replace a module, and forget what is compiled of it."""
        (self.root / path).write_text(code, encoding="utf-8")
        compiled = importlib.util.cache_from_source(str(self.root / path))
        Path(compiled).unlink(missing_ok=True)

    def pytest(self, arguments: list[str], cache: Path, limit: float) -> str:
        """Run tests up to the first failure: its name, what stopped pytest, or nothing."""
        command = [self.python, "-m", "pytest", "-q", "-x", "--hypothesis-seed=0", *arguments]
        with tempfile.TemporaryFile("w+") as output:
            process = subprocess.Popen(
                command, **self.place(cache), stdin=subprocess.DEVNULL, stdout=output,
                stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
            try:
                code = process.wait(limit)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            output.seek(0)
            text = output.read()
        if code in (0, 5):  # 5: no test of this kind
            return ""
        failed = re.search(r"^(?:FAILED|ERROR) (\S.*?)(?: - .*)?$", text, re.MULTILINE)
        return (
            failed[1] if failed else f"no end in {limit:.0f} s" if code is None else f"exit {code}"
        )

    def finds(self, mutant: Mutant, kind: str, files: list[str], seconds: float) -> str:
        """Name of a test in ``files`` that fails on the mutant alone, or nothing."""
        arguments, limit = [*KINDS[kind], *files], GENEROUS + 10.0 * seconds
        while True:
            self.write(mutant.path, mutant.code)
            try:
                with tempfile.TemporaryDirectory() as cache:
                    self.link_caches(Path(cache), self.cache / PACKAGE)
                    failed = self.pytest(arguments, Path(cache), limit)
            finally:
                self.write(mutant.path, mutant.original())
            if not failed:
                return ""
            named = failed.startswith("test/")
            again = [*KINDS[kind], failed] if named else arguments
            if not self.pytest(again, self.cache, limit):
                return failed if named else f"{failed}: {' '.join(files)}"
            if not named:
                print(f"  {failed} without the mutant too: {' '.join(files)}", flush=True)
                return ""
            arguments += ["--deselect", failed]


class Suite:
    """The tests of one revision, and what they said about mutants."""

    def __init__(self, revision: str, results: dict, options: argparse.Namespace) -> None:
        """Take up what the results hold for these tests."""
        self.revision, self.options, self.results = revision, options, results
        tree = digest(git("rev-parse", f"{revision}:test", f"{revision}:pyproject.toml"))[:12]
        self.verdicts = results["verdicts"].setdefault(tree, {})
        self.runs = results["runs"].setdefault(
            f"{tree} on {git('rev-parse', f'HEAD:{PACKAGE}')}", {}
        )
        self.files = [
            file
            for file in git("ls-tree", "-r", "--name-only", revision, "test").split()
            if Path(file).name.startswith("test_") and file.endswith(".py")
        ]

    def near(self, mutant: Mutant) -> list[list[str]]:
        """The test file of a module, then the others of its folder."""
        module = Path("test", *Path(mutant.path).parts[1:])
        own = str(module.with_name(f"test_{module.name.lstrip('_')}"))
        folder = module.parent
        while not (room := [f for f in self.files if folder in Path(f).parents]) and folder.name:
            folder = folder.parent
        room = [f for f in room if f != own] if folder != Path("test") else []
        return [files for files in ([own] if own in self.files else [], room) if files]

    def judge(self, mutants: list[Mutant], first: dict[str, str]) -> None:
        """Give each mutant a verdict; ``first`` are files that found it in another suite."""
        wanted = LEVELS.index(self.options.level)
        for level in range(wanted + 1):
            open_ = [m for m in mutants if not self.known(m, level)]
            if not open_:
                continue
            with contextlib.ExitStack() as stack:
                copies: queue.Queue[Copy] = queue.Queue()
                for _ in range(self.options.jobs):
                    folder = tempfile.TemporaryDirectory(dir=self.options.output, prefix="copy-")
                    copies.put(Copy(Path(stack.enter_context(folder)).resolve(), self.revision))

                def with_copy(action, *arguments, copies=copies):
                    copy = copies.get()
                    try:
                        return action(copy, *arguments)
                    finally:
                        copies.put(copy)

                with ThreadPoolExecutor(self.options.jobs) as threads:
                    if level:
                        self.probe(open_, level, copies, threads, with_copy)
                    asked = [
                        threads.submit(with_copy, self.ask, m, level, first.get(m.key))
                        for m in open_
                    ]
                    for answer in asked:
                        answer.result()

    def known(self, mutant: Mutant, level: int) -> bool:
        verdict = self.verdicts.get(mutant.key)
        return bool(verdict) and (
            bool(verdict["killed_by"]) or LEVELS.index(verdict["level"]) >= level
        )

    def ask(self, copy: Copy, mutant: Mutant, level: int, first: str | None) -> None:
        """Let the tests of one level judge one mutant, the cheap ones first."""
        begin, killed_by = time.monotonic(), ""
        if level == 0:
            steps = [("unit", files, 0.0) for files in self.near(mutant)]
            if first in self.files:
                steps = [(kind, [first], 0.0) for kind in KINDS] + steps
        else:
            kinds = list(KINDS)[:1] if level == 1 else list(KINDS)[1:]
            steps = [step for kind in kinds for step in self.reaching(mutant, kind)]
        for kind, files, seconds in steps:
            killed_by = copy.finds(mutant, kind, files, seconds)
            if killed_by:
                break
        took = round(time.monotonic() - begin, 1)
        verdict = {"killed_by": killed_by, "level": LEVELS[level], "seconds": took}
        self.verdicts[mutant.key] = {**verdict, "mutant": f"{mutant.path}:{mutant.line}"}
        save(self.results, self.options.output)
        said = f"killed by {killed_by}" if killed_by else f"survives ({LEVELS[level]})"
        print(f"{self.revision[:7]} {mutant.path}:{mutant.line} {said}, {took:.0f} s", flush=True)

    def probe(self, mutants, level, copies, threads, with_copy) -> None:
        """Run every test file on the package with probes, where that was not done before."""
        probes: dict[str, list[Mutant]] = {}
        for mutant in mutants:
            probes.setdefault(mutant.path, []).append(mutant)
        for copy in list(copies.queue):
            for path, its in probes.items():
                copy.write(path, with_probes(its[0].original(), its))
        keys = {m.key for m in mutants}
        kinds = list(KINDS)[:1] if level == 1 else list(KINDS)[1:]
        wanted = []
        for kind in kinds:
            for file in self.files:
                text = git("show", f"{self.revision}:{file}") if kind != "unit" else ""
                known = set(self.runs.get(f"{kind} {file}", {}).get("asked", ()))
                if (kind == "unit" or f"mark.{kind}" in text) and not keys <= known:
                    wanted.append((kind, file))
        for k, done in enumerate([threads.submit(with_copy, self.run, *w, keys) for w in wanted]):
            done.result()
            print(
                f"\r{k + 1} of {len(wanted)} files on the package with probes", end="", flush=True
            )
        print()
        for copy in list(copies.queue):
            for path, its in probes.items():
                copy.write(path, its[0].original())

    def run(self, copy: Copy, kind: str, file: str, keys: set[str]) -> None:
        """Note how long a file takes and which mutants' functions it runs."""
        copy.reached.write_text("")
        begin = time.monotonic()
        copy.pytest([*KINDS[kind], "--maxfail=1000000", file], copy.cache, 10 * GENEROUS)
        seconds, reached = time.monotonic() - begin, set(copy.reached.read_text().split())
        old = self.runs.get(f"{kind} {file}", {"asked": [], "reached": []})
        self.runs[f"{kind} {file}"] = {
            "seconds": round(seconds, 1),
            "asked": sorted(keys | set(old["asked"])),
            "reached": sorted(reached | set(old["reached"])),
        }
        save(self.results, self.options.output)

    def reaching(self, mutant: Mutant, kind: str):
        """Files that run a mutant's function, the fast ones first, some at a time."""
        near = [file for files in self.near(mutant) for file in files] if kind == "unit" else []
        found = sorted(
            (run["seconds"], name.split()[1])
            for name, run in self.runs.items()
            if name.startswith(f"{kind} ") and mutant.key in run["reached"]
        )
        found = [(seconds, file) for seconds, file in found if file not in near]
        for k in range(0, len(found), FILES_AT_ONCE):
            some = found[k : k + FILES_AT_ONCE]
            yield kind, [file for _, file in some], sum(seconds for seconds, _ in some)

    def says(self, mutant: Mutant) -> str:
        verdict = self.verdicts.get(mutant.key)
        if not verdict:
            return "not asked"
        return verdict["killed_by"] or f"survives ({verdict['level']})"


def save(results: dict, folder: Path) -> None:
    unfinished = folder / f"results.{time.monotonic_ns()}"
    unfinished.write_text(json.dumps(results, indent=1))
    unfinished.replace(folder / "results.json")


def table(mutants: list[Mutant], suites: list[Suite]) -> str:
    rows = [["where", "operator", "change", *(f"tests of {s.revision[:10]}" for s in suites)]]
    rows.append(["---"] * len(rows[0]))
    for m in mutants:
        said = [suite.says(m) for suite in suites]
        rows.append([f"{m.path}:{m.line}", m.operator, f"`{m.change}`", *said])
    return "".join("| " + " | ".join(w.replace("|", "\\|") for w in row) + " |\n" for row in rows)


def main(arguments: list[str] | None = None) -> int:
    """Exit code: 1 where a mutant survives that the other suite finds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--tests", default="HEAD", help="revision of the tests that judge")
    parser.add_argument(
        "--against", metavar="REV", help="revision of tests they must not fall behind"
    )
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--level", choices=LEVELS, default="all", help="how far a mutant is followed"
    )
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--output", type=Path, default=ROOT / "output/mutants")
    options = parser.parse_args(arguments)
    if git("status", "--porcelain", PACKAGE):
        parser.error(f"{PACKAGE} has changes that are not committed")
    options.output.mkdir(parents=True, exist_ok=True)
    kept = options.output / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {"verdicts": {}, "runs": {}}
    mutants = sample(options.seed, options.count)
    new = Suite(options.tests, results, options)
    suites = [new] + ([Suite(options.against, results, options)] if options.against else [])
    hints = {}
    for verdicts in results["verdicts"].values():
        hints |= {
            key: v["killed_by"].split("::")[0] for key, v in verdicts.items() if v["killed_by"]
        }
    new.judge(mutants, hints)
    if options.against:
        suites[1].judge([m for m in mutants if not new.verdicts[m.key]["killed_by"]], {})
    written = table(mutants, suites)
    (options.output / "mutants.md").write_text(written)
    print(written)
    killed = [m for m in mutants if new.verdicts[m.key]["killed_by"]]
    print(f"{len(killed)} of {len(mutants)} found by the tests of {options.tests}")
    lost = [
        m for m in mutants if m not in killed and suites[-1].verdicts[m.key]["killed_by"]
    ]  # fmt: skip
    for m in lost:
        print(f"found by the tests of {options.against} alone: {m.path}:{m.line} {m.change}")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
