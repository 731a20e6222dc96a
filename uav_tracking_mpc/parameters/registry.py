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

"""What people add is found by name: in its room, by an entry point, or as ``path.py:Class``.

A class in a file of its room says its name in a line of its own: ``laws/l1.py`` holds a class with
``name = "l1"``. An installed package adds one through an entry point whose group is the room, for
example in its ``setup.py``::

    entry_points={"uav_tracking_mpc.laws": ["pursuit = my_package.pursuit:Pursuit"]}

Listing names imports nothing. Each room keeps its :class:`ExtensionPoint` beside its base.
"""

from __future__ import annotations

import difflib
import functools
import importlib
import importlib.util
import logging
import re
import sys
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def did_you_mean(name: object, known: Iterable[object]) -> str:
    """The nearest name in words, to stand right behind the wrong one; "" if none is near.

    Args:
        name: As it was typed.
        known: Names that there are.
    """
    spelt = {str(candidate).lower(): str(candidate) for candidate in known}
    if str(name) in spelt.values():
        return ""
    nearest = difflib.get_close_matches(str(name).lower(), spelt, n=1)
    return f" (did you mean {spelt[nearest[0]]!r}?)" if nearest else ""


logger = logging.getLogger(__name__)

PACKAGE = Path(__file__).parents[1]
NAME = re.compile(r'^    name\b[^=\n]*= "(\w+)"', re.MULTILINE)  # in the body of a class


class ExtensionError(ValueError):
    """There is no extension of that name, or it is not what its base asks for."""


@dataclass(frozen=True)
class ExtensionPoint:
    """A kind of thing that people add.

    Attributes:
        title: What a message calls one of them.
        base: Of all of them. Its package holds those that come with the project.
    """

    title: str
    base: type

    @property
    def room(self) -> str:
        """Package that holds those that come with the project; also the entry points' group."""
        module = self.base.__module__
        package = hasattr(sys.modules[module], "__path__")
        return module if package else module.rpartition(".")[0]

    @property
    def own_names(self) -> list[str]:
        """Names of those that come with the project, sorted."""
        return sorted(_own_modules(self.room))

    @property
    def names(self) -> list[str]:
        """Names of all that are installed, sorted."""
        return names_of(self.room)

    def find(self, name: str) -> type[Any]:
        """Class of a name.

        Args:
            name: Of one that is installed, or ``path.py:Class``, or ``module:Class``.

        Raises:
            ExtensionError: There is none, it cannot be loaded, or it does not derive from the base.
        """
        if ":" in name:
            return self._checked(name, _loaded(self.title, name, lambda: _referred(name)))
        if module := _own_modules(self.room).get(name):
            return self._of_module(name, importlib.import_module(module))
        for point in entry_points(self.room):
            if point.name == name:
                return self._checked(name, _loaded(self.title, name, point.load))
        raise ExtensionError(
            f"{self.title} is {name!r}{did_you_mean(name, self.names)}, must be one of "
            f"{', '.join(self.names)}, or path.py:Class"
        )

    def own(self) -> dict[str, type[Any]]:
        """Classes of those that come with the project, by name."""
        return {name: self.find(name) for name in self.own_names}

    def all(self) -> dict[str, type[Any]]:
        """Classes of all that are installed, by name; one that fails is logged and left out."""
        found = self.own()
        for name in (name for name in self.names if name not in found):
            try:
                found[name] = self.find(name)
            except ExtensionError as error:
                logger.warning("%s; it is left out", error)
        return found

    def _of_module(self, name: str, module: ModuleType) -> type[Any]:
        for value in vars(module).values():
            kind = isinstance(value, type) and issubclass(value, self.base)
            if kind and value.__module__ == module.__name__ and vars(value).get("name") == name:
                return value
        raise ExtensionError(
            f"{module.__file__} holds no {self.base.__name__} whose name is {name!r}"
        )

    def _checked(self, name: str, value: Any) -> type[Any]:
        if not (isinstance(value, type) and issubclass(value, self.base)):
            base = f"{self.room}.{self.base.__name__}"
            raise ExtensionError(f"{self.title} {name!r} must derive from {base}")
        return value


def names_of(room: str) -> list[str]:
    """Names of all that are installed of one kind, sorted.

    Args:
        room: Package that holds those that come with the project; also the entry points' group.
    """
    return sorted({*_own_modules(room), *(point.name for point in entry_points(room))})


@functools.cache  # parameters that change in flight ask for names again and again
def _own_modules(room: str) -> dict[str, str]:
    """Module of each thing that a room's files hold, by its name."""
    folder = PACKAGE.joinpath(*room.split(".")[1:])
    return {
        name: f"{room}.{path.stem}"
        for path in folder.glob("*.py")
        for name in NAME.findall(path.read_text(encoding="utf-8"))
    }


@functools.cache  # it looks into every package that is installed
def entry_points(group: str) -> tuple[EntryPoint, ...]:
    """Entry points of a group, looked up once.

    Args:
        group: Its name.
    """
    from importlib import metadata  # only now: it takes as long as all else that help needs

    return tuple(metadata.entry_points(group=group))


def _loaded(title: str, name: str, load: Callable[[], Any]) -> Any:
    """What ``load`` returns; whatever a user's file raises meanwhile is an ExtensionError."""
    try:
        return load()
    except ExtensionError:
        raise
    except Exception as error:
        raise ExtensionError(
            f"{title} {name!r} cannot be loaded: {type(error).__name__}: {error}"
        ) from error


def _referred(reference: str) -> Any:
    """Value of ``path.py:Class`` or ``module:Class``."""
    where, _, attribute = reference.rpartition(":")
    file = where.endswith(".py")
    module = _module_of_file(Path(where)) if file else importlib.import_module(where)
    try:
        return getattr(module, attribute)
    except AttributeError:
        raise ExtensionError(f"{where} has no {attribute}") from None


def _module_of_file(path: Path) -> ModuleType:
    path = path.resolve()
    if not path.is_file():
        raise ExtensionError(f"there is no file {path}")
    # Under one name in every process, so that what is defined there can be pickled; and one for
    # each path, for two folders may each hold a `mine.py`.
    name = f"extension_{path.stem}_{zlib.crc32(bytes(path)):08x}"
    if present := sys.modules.get(name):
        return present
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        specification.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
