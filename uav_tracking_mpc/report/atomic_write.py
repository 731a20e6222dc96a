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

"""Files that are whole or absent: a reader never meets half of one."""

from __future__ import annotations

import json
import os
import secrets
from pathlib import Path
from typing import Any


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file beside its place, then move it there.

    A symbolic link in that place is replaced, not followed, so nothing is written elsewhere.

    Args:
        path: Where the file shall be; its folder exists.
        content: What it shall hold.

    Raises:
        OSError: The folder cannot be written to; no temporary file is left behind.
    """
    # Not tempfile: its files are private to their owner, reports are for sharing (umask decides).
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        with open(temporary, "xb") as file:
            file.write(content)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def json_text(content: Any) -> str:
    """JSON for people and programs: indented, never NaN.

    Args:
        content: Plain values.

    Raises:
        ValueError: A number is not finite.
    """
    return json.dumps(content, indent=2, allow_nan=False)


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file as a whole.

    Args:
        path: Where the file shall be; its folder exists.
        content: Plain values, never NaN.

    Raises:
        OSError: The folder cannot be written to.
    """
    write_atomically(path, (json_text(content) + "\n").encode())
