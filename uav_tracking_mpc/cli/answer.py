"""How a command prints what it found: one JSON object, or words for people."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from typing import Any

NARROWEST = 134  # characters: a table that is cut off tells nothing


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

    console = Console(file=sys.stdout)
    console.width = max(console.width, NARROWEST)
    for part in words:
        console.print(part, markup=False, highlight=False, soft_wrap=isinstance(part, str))
