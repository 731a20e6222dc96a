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

"""Let the tests of two revisions judge mutants of the package.

::

    python test/mutant_trial.py --tests HEAD --against 5f647f0

fails where a mutant survives the tests of the first revision that those of the second find. The
package is that of HEAD, the tests are ``test/`` and ``pyproject.toml`` of their revision.

Each mutant is written into a copy of the checkout, which has a copy of ``.venv`` and of the cache
of compiled solvers. It meets the test file of its module and those of the folder; then every file
that runs its function, or loads its module where it stands in no function; nodes and browsers last.
Which files those are is known from a run of each file on the unmutated package with probes. A test
finds a mutant if it fails on it, or does not end, and passes on the unmutated package. Verdicts go
to ``results.json`` as they come; a second call goes on where the first ended.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib.util
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from mutants import PACKAGE, ROOT, Mutant, digest, first_line, git, sample

from uav_tracking_mpc.report.pages import Table

LEVELS = ("near", "unit", "all")  # the module's folder; all without processes; everything
KINDS = {
    "unit": ["-m", "not nodes and not browser and not long"],
    "nodes": ["-m", "nodes and not long"],
    "browser": ["-m", "browser and not long"],
}
KINDS_OF = {"near": ["unit"], "unit": ["unit"], "all": ["nodes", "browser"]}
# Sources of machine code, which is kept: whoever asks for the code is said to run them.
SOURCES = re.compile(f"{PACKAGE}/mpc/(newton/.*|stage_code|machine_code)[.]py")
ASKED = (f"{PACKAGE}/mpc/compiled_method.py", "def method_folder(")
PROBE = """
from pathlib import Path
seen = set()
def reached(key):
    if key not in seen:
        seen.add(key)
        with Path(__file__).with_name("reached.txt").open("a") as file:
            file.write(key + "\\n")
"""
FILES_AT_ONCE = 20
GENEROUS = 600.0  # s, to which comes ten times what the files took on the unmutated package


class Copy:
    """A checkout of HEAD with the tests of a revision, in which the package can be mutated."""

    def __init__(self, folder: Path, tests: str) -> None:
        self.root, self.cache = folder / "checkout", folder / "cache"
        self._process: subprocess.Popen | None = None
        self._stopped = False
        self.root.mkdir()
        self._unpack("HEAD")
        shutil.rmtree(self.root / "test")
        self._unpack(tests, "test", "pyproject.toml")
        self._copy_environment()
        self.user_cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        self._fill(self.cache, self.user_cache / PACKAGE)
        command = [self.python, "-c", f"import {PACKAGE}; print({PACKAGE}.__file__)"]
        found = subprocess.run(command, **self._place(self.cache), stdout=-1, text=True).stdout
        if found.strip() != str(self.root / PACKAGE / "__init__.py"):
            raise SystemExit(f"the copy must import its own package, imports {found.strip()!r}")

    def _unpack(self, revision: str, *paths: str) -> None:
        packed = subprocess.run(
            ["git", "archive", revision, *paths], cwd=ROOT, stdout=-1, check=True
        )
        subprocess.run(["tar", "-x"], cwd=self.root, input=packed.stdout, check=True)

    def _copy_environment(self) -> None:
        environment = self.root / ".venv"
        shutil.copytree(ROOT / ".venv", environment, symlinks=True, copy_function=os.link)
        self.python = str(environment / "bin/python")
        (site,) = environment.glob("lib/python*/site-packages")
        for file in [*environment.glob("bin/*"), *site.glob("__editable__*.py")]:
            content = file.read_bytes() if file.is_file() and not file.is_symlink() else b""
            if os.fsencode(ROOT) in content:
                mode = file.stat().st_mode
                file.unlink()  # a link: the original keeps its content
                file.write_bytes(content.replace(os.fsencode(ROOT), os.fsencode(self.root)))
                file.chmod(mode)
        for compiled in site.glob("__pycache__/__editable__*"):
            compiled.unlink()
        (site / "mutant_probe.py").write_text(PROBE)
        self.reached = site / "reached.txt"

    @contextlib.contextmanager
    def _cache(self, solvers: Path | None) -> Iterator[Path]:
        """A folder for ``XDG_CACHE_HOME``: with these solvers, and the rest of the user's."""
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            self._fill(Path(folder), solvers)
            yield Path(folder)

    def _fill(self, cache: Path, solvers: Path | None) -> None:
        (cache / PACKAGE).mkdir(parents=True)
        if solvers and solvers.is_dir():
            shutil.copytree(solvers, cache / PACKAGE, dirs_exist_ok=True)
        for other in self.user_cache.glob("*"):
            if other.name != PACKAGE:
                (cache / other.name).symlink_to(other)

    def _place(self, cache: Path) -> dict:
        """Where a process of this copy runs, as arguments of subprocess."""
        kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
        path = os.pathsep.join([str(self.root / ".venv/bin"), kept.get("PATH", "")])
        return {"cwd": self.root, "env": {**kept, "PATH": path, "XDG_CACHE_HOME": str(cache)}}

    def write(self, path: str, code: str) -> None:
        """Replace a module, and forget what Python compiled of it."""
        (self.root / path).write_text(code, encoding="utf-8")
        compiled = importlib.util.cache_from_source(str(self.root / path))
        Path(compiled).unlink(missing_ok=True)

    def pytest(self, arguments: list[str], cache: Path, limit: float) -> str:
        """Run tests. Returns the first that fails, or what ended pytest, or nothing."""
        command = [self.python, "-m", "pytest", "-q", "--hypothesis-seed=0", *arguments]
        streams = {"stdin": subprocess.DEVNULL, "stderr": subprocess.STDOUT}
        with tempfile.TemporaryFile("w+", errors="replace") as output:
            self._process = subprocess.Popen(
                command, **self._place(cache), **streams, stdout=output, start_new_session=True
            )
            try:
                code = self._process.wait(limit)
            except subprocess.TimeoutExpired:
                code = None
            self._end()
            if self._stopped:
                raise InterruptedError
            output.seek(0)
            text = output.read()
        if code in (0, 5):  # 5: no test of this kind
            return ""
        failed = re.search(r"^(?:FAILED|ERROR) (test/.*?)(?: - .*)?$", text, re.MULTILINE)
        return (
            failed[1] if failed else f"no end in {limit:.0f} s" if code is None else f"exit {code}"
        )

    def _end(self) -> None:
        """End pytest and what it started."""
        if self._process:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()

    def stop(self) -> None:
        self._stopped = True
        self._end()

    def finds(self, mutant: Mutant, kind: str, files: list[str], seconds: float) -> str:
        """Name of a test in ``files`` that fails on the mutant alone, or nothing."""
        arguments, limit = [*KINDS[kind], "-x", *files], GENEROUS + 10.0 * seconds
        while True:
            self.write(mutant.path, mutant.code)
            with self._cache(self.cache / PACKAGE) as cache:
                failed = self.pytest(arguments, cache, limit)
            self.write(mutant.path, mutant.original)
            named = failed.startswith("test/")
            again = [*KINDS[kind], failed] if named else arguments
            # Without solvers, for those of a mutant may have to be compiled too.
            with self._cache(None) as cache:
                if not failed or not self.pytest(again, cache, limit):
                    return failed if named or not failed else f"{failed}: {' '.join(files)}"
            print(f"  fails without the mutant too: {failed}", flush=True)
            if named and "::" in failed and failed not in arguments:
                arguments += ["--deselect", failed]
            elif named and files[1:]:
                return self.finds(mutant, kind, [f for f in files if f not in failed], seconds)
            else:
                return ""

    def runs(self, kind: str, file: str) -> tuple[float, list[str]]:
        """How long a test file takes, in [s], and the keys of the probes that it meets."""
        self.reached.write_text("")
        begin = time.monotonic()
        self.pytest([*KINDS[kind], file], self.cache, 10.0 * GENEROUS)
        return time.monotonic() - begin, sorted(set(self.reached.read_text().split()))


class Suite:
    """The tests of one revision, and what they said about mutants."""

    def __init__(self, revision: str, results: dict, jobs: int, output: Path) -> None:
        self.revision, self.results, self.jobs, self.output = revision, results, jobs, output
        tests = digest(git("rev-parse", f"{revision}:test", f"{revision}:pyproject.toml"))[:12]
        self.verdicts = results["verdicts"].setdefault(tests, {})
        listed = git("ls-tree", "-r", revision, "test").splitlines()
        blobs = {path: words.split()[2] for words, path in (line.split("\t") for line in listed)}
        self.files = [f for f in blobs if re.fullmatch(r"test_.*[.]py", Path(f).name)]
        self.blobs = blobs

    def judge(self, mutants: list[Mutant], level: str, before: dict[str, str]) -> None:
        """Give each mutant a verdict; ``before`` are the files that found it at another time."""
        for step in LEVELS[: LEVELS.index(level) + 1]:
            asked = [m for m in mutants if not self._known(m, step)]
            if asked:
                with contextlib.ExitStack() as stack:
                    self._judge(asked, step, before, stack)

    def _judge(self, mutants, level, before, stack) -> None:
        self._copies: queue.Queue[Copy] = queue.Queue()
        for _ in range(self.jobs):
            folder = tempfile.TemporaryDirectory(
                dir=self.output, prefix="copy-", ignore_cleanup_errors=True
            )
            self._copies.put(Copy(Path(stack.enter_context(folder)), self.revision))
        threads = stack.enter_context(ThreadPoolExecutor(self.jobs))
        for copy in list(self._copies.queue):
            stack.callback(copy.stop)
        stack.callback(threads.shutdown, wait=False, cancel_futures=True)
        if level != "near":
            self._probe(mutants, level, threads)

        def ask(copy: Copy, mutant: Mutant):
            begin = time.monotonic()
            steps = self._steps(mutant, level, before.get(mutant.key))
            found = next(filter(None, (copy.finds(mutant, *step) for step in steps)), "")
            return mutant, found, time.monotonic() - begin

        for mutant, found, seconds in self._each(threads, ask, [(m,) for m in mutants]):
            where = f"{mutant.path}:{mutant.line}"
            self.verdicts[mutant.key] = {"mutant": where, "killed_by": found, "level": level}
            self._save()
            said = f"{self.revision[:10]} {where} {self.says(mutant)}, {seconds:.0f} s"
            print(said, flush=True)

    def _each(self, threads, action: Callable, arguments: list[tuple]) -> Iterator:
        """Results of ``action(copy, *arguments)``, as they come."""

        def with_copy(own: tuple):
            copy = self._copies.get()
            try:
                return action(copy, *own)
            finally:
                self._copies.put(copy)

        for done in as_completed([threads.submit(with_copy, own) for own in arguments]):
            yield done.result()

    def _known(self, mutant: Mutant, level: str) -> bool:
        verdict = self.verdicts.get(mutant.key, {"level": LEVELS[0], "killed_by": ""})
        followed = LEVELS.index(verdict["level"]) >= LEVELS.index(level)
        return mutant.key in self.verdicts and (bool(verdict["killed_by"]) or followed)

    def _near(self, mutant: Mutant) -> list[list[str]]:
        """The test file of the module, then the others of its folder."""
        module = Path("test", *Path(mutant.path).parts[1:])
        own = str(module.with_name(f"test_{module.name.lstrip('_')}"))
        for folder in list(module.parents)[:-2]:
            room = [f for f in self.files if folder in Path(f).parents]
            if room:
                return [[f for f in room if f == own], [f for f in room if f != own]]
        return []

    def _steps(self, mutant: Mutant, level: str, before: str | None) -> Iterator[tuple]:
        """Kind, files, and their time in [s], in the order in which a mutant meets them."""
        near = self._near(mutant)
        if level == "near":
            if before in self.files:
                yield from ((kind, [before], 0.0) for kind in KINDS)
            yield from (("unit", files, 0.0) for files in near if files)
            return
        for kind in KINDS_OF[level]:
            past = [f"unit {file}" for files in near for file in files]
            runs = ((file, self._run(kind, file)) for file in self.files)
            found = sorted(
                (run["seconds"], file)
                for file, run in runs
                if mutant.key in run["reached"] and f"{kind} {file}" not in past
            )
            for k in range(0, len(found), FILES_AT_ONCE):
                some = found[k : k + FILES_AT_ONCE]
                yield kind, [file for _, file in some], sum(seconds for seconds, _ in some)

    def _probe(self, mutants: list[Mutant], level: str, threads) -> None:
        """Learn which files run which mutants' functions."""
        keys, wanted = {m.key for m in mutants}, []
        for kind in KINDS_OF[level]:
            for file in self.files:
                known = keys <= set(self._run(kind, file)["asked"])
                if kind == "unit" or f"mark.{kind}" in git("show", self.blobs[file]):
                    wanted += [] if known else [(kind, file)]
        probed = with_probes(mutants)
        for copy in list(self._copies.queue):
            for path, code in probed.items():
                copy.write(path, code)

        def run(copy: Copy, kind: str, file: str):
            return kind, file, *copy.runs(kind, file)

        for k, (kind, file, seconds, reached) in enumerate(self._each(threads, run, wanted)):
            known = self._run(kind, file)
            self.results["runs"][f"{kind} {file} {self.blobs[file]}"] = {
                "seconds": round(seconds, 1),
                "asked": sorted({*keys, *known["asked"]}),
                "reached": sorted({*reached, *known["reached"]}),
            }
            self._save()
            print(f"{k + 1} of {len(wanted)} files with probes: {file}", flush=True)
        for copy in list(self._copies.queue):
            for path in probed:
                copy.write(path, (ROOT / path).read_text(encoding="utf-8"))

    def _run(self, kind: str, file: str) -> dict:
        """What is known of a run of a file, in whatever revision it is the same."""
        unknown = {"seconds": 0.0, "asked": [], "reached": []}
        return self.results["runs"].get(f"{kind} {file} {self.blobs[file]}", unknown)

    def _save(self) -> None:
        unfinished = self.output / "results.unfinished"
        unfinished.write_text(json.dumps(self.results, indent=1))
        unfinished.replace(self.output / "results.json")

    def says(self, mutant: Mutant) -> str:
        verdict = self.verdicts.get(mutant.key)
        if not verdict:
            return "not asked"
        found = verdict["killed_by"]
        return f"killed by {found}" if found else f"survives ({verdict['level']})"


def with_probes(mutants: list[Mutant]) -> dict[str, str]:
    """Modules, by path, that tell the keys of those mutants whose functions run."""
    places: dict[str, list[tuple[int, str]]] = {}
    for mutant in mutants:
        places.setdefault(mutant.path, []).append((mutant.line, mutant.key))
        if SOURCES.fullmatch(mutant.path):
            lines = (ROOT / ASKED[0]).read_text(encoding="utf-8").splitlines()
            line = next(k for k, text in enumerate(lines) if text.startswith(ASKED[1]))
            places.setdefault(ASKED[0], []).append((line + 2, mutant.key))
    return {path: _probed(path, lines) for path, lines in places.items()}


def _probed(path: str, places: list[tuple[int, str]]) -> str:
    source = (ROOT / path).read_text(encoding="utf-8")
    lines, marks = source.splitlines(), []
    functions = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        and not SOURCES.fullmatch(path)  # numba does not compile a probe
        and first_line(node.body[0]) > node.lineno
    ]
    for line, key in places:
        call = f'__import__("mutant_probe").reached("{key}")'
        inside = [n for n in functions if first_line(n.body[0]) <= line <= (n.end_lineno or 0)]
        if inside:
            node = max(inside, key=lambda node: node.lineno)
            start = node.body[1 if ast.get_docstring(node) and len(node.body) > 1 else 0]
            marks.append((first_line(start) - 1, " " * start.col_offset + call))
        else:
            marks.append((len(lines), call))
    for place, call in sorted(marks, reverse=True):
        lines.insert(place, call)
    return "\n".join(lines) + "\n"


def table(mutants: list[Mutant], suites: list[Suite]) -> str:
    """Markdown: what each mutant is, and what the suites say."""
    headings = ["where", "operator", "before", "after", *(f"tests of {s.revision}" for s in suites)]
    rows = [
        [
            f"{m.path}:{m.line}",
            m.operator,
            *(f"`{code}`" for code in m.change),
            *(suite.says(m) for suite in suites),
        ]
        for m in mutants
    ]
    return Table(headings, rows).as_markdown()


def main(arguments: list[str] | None = None) -> int:
    """Exit code: 1 where a mutant survives that the other tests find."""
    parser = argparse.ArgumentParser(description="Let the tests of two revisions judge mutants.")
    parser.add_argument("--tests", metavar="REV", default="HEAD", help="the tests that judge")
    parser.add_argument("--against", metavar="REV", help="tests that may not find more")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--level", choices=LEVELS, default="all", help="tests of the module's "
                        "folder, all but those with nodes or a browser, or all")  # fmt: skip
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--output", type=Path, default=ROOT / "output/mutants")
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job too
    if git("status", "--porcelain", PACKAGE):
        parser.error(f"all changes of {PACKAGE} must be committed")
    output = options.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    kept = output / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {"verdicts": {}, "runs": {}}
    before = {
        key: verdict["killed_by"].split("::")[0]
        for verdicts in results["verdicts"].values()
        for key, verdict in verdicts.items()
    }
    mutants = sample(options.seed, options.count)
    new = Suite(options.tests, results, options.jobs, output)
    new.judge(mutants, options.level, before)
    survivors = [m for m in mutants if not new.verdicts[m.key]["killed_by"]]
    suites, lost = [new], []
    if options.against:
        old = Suite(options.against, results, options.jobs, output)
        old.judge(survivors, options.level, before)
        suites, lost = [new, old], [m for m in survivors if old.verdicts[m.key]["killed_by"]]
    written = table(mutants, suites)
    (output / "mutants.md").write_text(written + "\n", encoding="utf-8")
    print(written)
    print(f"The tests of {options.tests} find {len(mutants) - len(survivors)} of {len(mutants)}.")
    for m in lost:
        print(f"The tests of {options.against} alone find {m.path}:{m.line}.")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
