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

"""The tables of topics and parameters in the documentation, written from the code.

``make docs`` writes them into ``docs/reference/topics_and_parameters.md``; a test compares.
"""

from __future__ import annotations

import sys
from pathlib import Path

from uav_tracking_mpc.nodes.topics import ALL
from uav_tracking_mpc.parameters.specification import Specification, specifications
from uav_tracking_mpc.settings.configuration import SECTIONS


def topic_table() -> str:
    """Markdown table of every topic."""
    lines = ["| topic | type | from | meaning |", "|---|---|---|---|"]
    lines += [
        f"| `{topic.name}` | {topic.type_name} | {topic.sender} | {topic.meaning} |"
        for topic in ALL
    ]
    return "\n".join(lines)


def parameter_table(section: str) -> str:
    """Markdown table of a section's parameters.

    Args:
        section: Name of the node, or ``mission``.
    """
    lines = ["| parameter | default | allowed | effect |", "|---|---|---|---|"]
    lines += [
        f"| `{item.name}` | {_default(item)} | {item.allowed} | {_effect(item)} |"
        for item in specifications(SECTIONS[section])
    ]
    return "\n".join(lines)


def tables() -> dict[str, str]:
    """Every table by the name of its place in the page."""
    return {"topics": topic_table(), **{section: parameter_table(section) for section in SECTIONS}}


def with_tables(text: str) -> str:
    """The text with each table put between its ``<!-- table NAME -->`` and ``<!-- end -->``.

    Args:
        text: Of a page in Markdown.

    Raises:
        ValueError: A table has no place in the text.
    """
    for name, table in tables().items():
        begin, end = f"<!-- table {name} -->\n", "<!-- end -->"
        before, found, rest = text.partition(begin)
        _, closed, after = rest.partition(end)
        if not (found and closed):
            raise ValueError(f"the text has no place for the table {name!r}")
        text = f"{before}{begin}{table}\n{end}{after}"
    return text


def _effect(item: Specification) -> str:
    fixed = " *Fixed: set at the start only.*" if item.fixed else ""
    return item.description.replace("|", "\\|") + fixed


def _default(item: Specification) -> str:
    value = item.default
    if isinstance(value, tuple):
        return ", ".join(f"{number:.6g}" for number in value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(with_tables(path.read_text(encoding="utf-8")), encoding="utf-8")
