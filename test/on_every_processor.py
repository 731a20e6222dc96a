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

"""Run the tests under every kernel of OpenBLAS that this processor can execute.

OpenBLAS, on which NumPy and SciPy rest, chooses its kernels by the processor, and they round
differently. ``OPENBLAS_CORETYPE`` makes it choose as another processor would::

    python test/on_every_processor.py [arguments of pytest]
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NEEDED = {"PRESCOTT": "pni", "HASWELL": "avx2", "ZEN": "avx2", "SKYLAKEX": "avx512f"}
CHECK = "import numpy; a = numpy.ones((64, 64)); assert (a @ a == 64.0).all()"


def executable() -> list[str]:
    """Core types whose instructions the processor has."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return []
    found = re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    flags = set(found[1].split()) if found else set()
    return [core for core, flag in NEEDED.items() if flag in flags]


def environment(core: str) -> dict[str, str]:
    return {**os.environ, "OPENBLAS_CORETYPE": core}


def main(arguments: list[str]) -> int:
    """Exit code: 0 where the tests pass under every core type."""
    cores = executable()
    print(f"core types that this processor executes: {', '.join(cores) or 'none to choose from'}")
    failed = []
    for core in cores:
        print(f"OPENBLAS_CORETYPE={core}", flush=True)
        subprocess.run([sys.executable, "-c", CHECK], check=True, env=environment(core))
        command = [sys.executable, "-m", "pytest", "-q", "-m", "not nodes", *arguments]
        if subprocess.run(command, cwd=ROOT, env=environment(core)).returncode:
            failed.append(core)
    print(
        f"failed under {', '.join(failed)}" if failed else f"passed under {len(cores)} core types"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
