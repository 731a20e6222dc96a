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

"""Tables for the terminal and for documentation; HTML pages that need no other file."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, StrictUndefined

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.atomic_write import write_atomically

# The picture in the tab of every page: an aircraft that circles a target.
ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    '<rect width="32" height="32" rx="7" fill="#0b3a5b"/>'
    '<circle cx="16" cy="16" r="10.5" fill="none" stroke="#56b4e9" stroke-width="2" '
    'stroke-dasharray="4 2.6"/><circle cx="16" cy="16" r="2.4" fill="#e69f00"/>'
    '<path d="M26.5 5.2 22 14.2l-2.6-3.4-4.2-1z" fill="#fff"/></svg>'
)
ICON_ADDRESS = f"data:image/svg+xml,{quote(ICON)}"
# A number a little below zero, rounded.
NEGATIVE_ZERO = re.compile(r"(?<![\w.])-(0(?:\.0+)?)(?![\w.])")


@dataclass(frozen=True)
class Table:
    """Rows of text under headings.

    Attributes:
        headings: Of the columns; a unit in brackets goes to a line of its own in the terminal.
        rows: Cells of every row, as many as there are headings. A row whose first cell is empty
            belongs to the row above it. Zeros in columns of numbers lose their minus sign.
        numeric: Headings of the columns that are aligned to the right.
        title: Above the table in the terminal.
        caption: Below it.
    """

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: Sequence[str] = ()
    title: str = ""
    caption: str = ""

    def __post_init__(self) -> None:
        """Zeros have no sign in the columns of numbers."""
        numbers = [heading in self.numeric for heading in self.headings]
        rows = [
            [
                NEGATIVE_ZERO.sub(r"\1", cell) if number else cell
                for cell, number in zip(row, numbers, strict=True)
            ]
            for row in self.rows
        ]
        object.__setattr__(self, "rows", rows)

    def __rich__(self) -> Any:
        """The table as rich prints it in the terminal."""
        from rich.box import SIMPLE_HEAD
        from rich.table import Table as RichTable
        from rich.text import Text

        table = RichTable(
            box=SIMPLE_HEAD, title=self.title, caption=self.caption, caption_justify="left"
        )
        for heading in self.headings:
            table.add_column(
                Text(heading.replace(" [", "\n[")),
                justify="right" if heading in self.numeric else "left",
                overflow="fold",
            )
        grouped = any(not row[0] for row in self.rows)
        for row in self.rows:
            if grouped and row[0]:
                table.add_section()
            table.add_row(*(Text(cell) for cell in row))
        return table

    def as_markdown(self) -> str:
        """The table as Markdown, without a line break at its end."""
        rules = ("---:" if heading in self.numeric else "---" for heading in self.headings)
        # A bar inside a cell would end it.
        cells = ([cell.replace("|", "\\|") for cell in row] for row in self.rows)
        lines = [list(self.headings), *cells]
        written = ["| " + " | ".join(line) + " |" for line in lines]
        return "\n".join([written[0], "|" + "|".join(rules) + "|", *written[1:]])

    def write_into(self, page: Path, name: str) -> None:
        """Put the table into a page, between ``<!-- table NAME -->`` and ``<!-- end -->``.

        Args:
            page: File of the page.
            name: Of the table's place.

        Raises:
            ParameterError: The page has no such place.
        """
        begin, end = f"<!-- table {name} -->\n", "<!-- end -->"
        before, found, rest = page.read_text(encoding="utf-8").partition(begin)
        _, closed, after = rest.partition(end)
        if not (found and closed):
            raise ParameterError(f"{page} has no place {begin.strip()!r} for the table")
        text = f"{before}{begin}{self.as_markdown()}\n{end}{after}"
        write_atomically(page, text.encode())


def render(
    package: str, template: str, filters: dict[str, Callable[..., str]], **values: Any
) -> str:
    """Fill in a template.

    Args:
        package: That holds the template.
        template: Name of its file.
        filters: Functions that the template applies, by name.
        values: What the template names.

    Returns:
        The page; what is text in the values is escaped.
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(filters)
    source = resources.files(package).joinpath(template).read_text("utf-8")
    return environment.from_string(source).render(**values)


def embedded(png: bytes) -> str:
    """A picture as an address that holds it.

    Args:
        png: Content of a PNG file.
    """
    return "data:image/png;base64," + base64.b64encode(png).decode()
