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

"""What a study found: plain values for programs, words for people, and the files of both."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.pages import Table, embedded, render
from uav_tracking_mpc.settings.tracking import PREDICTIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Say = Callable[[str], None]  # told in words what is being done


def plain(content: Any) -> Any:
    """Values as JSON knows them: what is not finite becomes null, a tuple a list."""
    return json.loads(json.dumps(content), parse_constant=lambda _: None)


@dataclass(frozen=True)
class Study:
    """What a study found, to be printed and written.

    Attributes:
        name: Of its JSON file and its HTML page, without their endings.
        content: Of the JSON file; what is not finite in it becomes null.
        words: Lines of text and tables for people.
        written: Line that says where the files are, with ``{}`` for their folder; empty for none.
        figures: Functions that draw the PNG files, by the files' names without the ending.
        files: Contents of further files, by their names.
        title: Of the HTML page, which holds words and figures; empty without one.
        description: Below the title.
        about: Heading and description of each figure on the page, by its name.
        tables: Tables for a page of the documentation, by the names of their places.
        good: Whether all is as it should be: the command's exit code is then 0.
        left: What the user's interruption left out, in words; empty if nothing. No page of the
            documentation is then changed.
    """

    name: str
    content: Mapping[str, Any]
    words: Sequence[str | Table]
    written: str = ""
    figures: Mapping[str, Callable[[], Figure]] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)
    title: str = ""
    description: str = ""
    about: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    good: bool = True
    left: str = ""

    def __post_init__(self) -> None:
        """Content as JSON knows it: a single number that is not finite must not cost all others."""
        object.__setattr__(self, "content", plain(self.content))

    def document(self, page: Path) -> None:
        """Put the tables into their places in a page of the documentation, if all was flown.

        Raises:
            ParameterError: The page has no place for a table.
        """
        if not self.left:
            for name, table in self.tables.items():
                table.write_into(page, name)

    def publish(self, output: Path | None) -> Sequence[str | Table]:
        """Write everything.

        Args:
            output: Folder of the files, made if it is not there; None writes none.

        Returns:
            Words for people, with the place of the files.

        Raises:
            OSError: The folder cannot be made or written to.
        """
        if output is None:
            return self.words
        # Only now: processes that fly a study's flights import its modules, and draw nothing.
        from uav_tracking_mpc.report.figure_style import save_figure

        output.mkdir(parents=True, exist_ok=True)
        write_json(output / f"{self.name}.json", self.content)
        for name, content in self.files.items():
            (output / name).parent.mkdir(exist_ok=True)
            write_atomically(output / name, content)
        pictures = {
            name: embedded(save_figure(draw(), output / f"{name}.png"))
            for name, draw in self.figures.items()
        }
        if self.title:
            page = render(
                "uav_tracking_mpc.studies",
                "study.html.j2",
                {},
                title=self.title,
                description=self.description,
                words=self.words,
                own=PREDICTIVE,
                pictures=[(*self.about[name], picture) for name, picture in pictures.items()],
            )
            write_atomically(output / f"{self.name}.html", page.encode())
        return [*self.words, *([self.written.format(output)] if self.written else [])]
