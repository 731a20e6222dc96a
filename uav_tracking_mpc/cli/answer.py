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

"""How a command prints what it found: one JSON object, or words for people."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from typing import Any

WIDEST = 500  # characters that any table may need


def answer(content: Any, words: Iterable[Any], as_json: bool) -> None:
    """Print the answer on stdout.

    Args:
        content: For programs: plain values, never NaN.
        words: For people: lines of text, and tables of rich.
        as_json: Print the content as one JSON object and nothing else.
    """
    if as_json:
        print(json.dumps(content, allow_nan=False))
        return
    from rich.console import Console
    from rich.measure import Measurement

    terminal = Console(file=sys.stdout).width
    for part in words:
        if isinstance(part, str):
            print(part)
            continue
        # As wide as it needs: a table that is cut off tells nothing.
        needed = Measurement.get(Console(width=WIDEST), Console(width=WIDEST).options, part).maximum
        Console(file=sys.stdout, width=max(terminal, needed)).print(part)
