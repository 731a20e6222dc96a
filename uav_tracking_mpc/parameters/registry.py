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

A room keeps one thing a file, and the file's name is the thing's name: ``laws/l1.py`` holds the law
``l1``. Files that begin with an underscore are shared parts. An installed package adds a thing
through an entry point whose group is the room, for example in its ``setup.py``::

    entry_points={"uav_tracking_mpc.laws": ["pursuit = my_package.pursuit:Pursuit"]}

Listing names imports nothing.
"""

from __future__ import annotations

import functools
import importlib
import importlib.util
import logging
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

from uav_tracking_mpc.parameters.suggestion import did_you_mean

logger = logging.getLogger(__name__)

PACKAGE = Path(__file__).parents[1]


class ExtensionError(ValueError):
    """There is no extension of that name, or it is not what its base asks for."""


@dataclass(frozen=True)
class Kind:
    """A kind of thing that people add.

    Attributes:
        title: What a message calls one of them.
        room: Package that holds those that come with the project; also the entry points' group.
        base: Name of the base class in that package.
    """

    title: str
    room: str
    base: str

    @property
    def base_class(self) -> type:
        """The base of all of this kind."""
        return getattr(importlib.import_module(self.room), self.base)

    @property
    def own_names(self) -> list[str]:
        """Names of those that come with the project, sorted."""
        return _own_names(self.room)

    @property
    def names(self) -> list[str]:
        """Names of all that are installed, sorted."""
        return sorted({*self.own_names, *(point.name for point in entry_points(self.room))})

    def find(self, name: str) -> type[Any]:
        """Class of a name.

        Args:
            name: Of one that is installed, or ``path.py:Class``, or ``module:Class``.

        Raises:
            ExtensionError: There is none, it cannot be loaded, or it does not derive from the base.
        """
        if ":" in name:
            return self._checked(name, _loaded(self.title, name, lambda: _referred(name)))
        if name in self.own_names:
            module = importlib.import_module(f"{self.room}.{name}")
            return self._of_module(name, module)
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
        base = self.base_class
        for value in vars(module).values():
            if not (isinstance(value, type) and issubclass(value, base)):
                continue
            if value.__module__ == module.__name__ and value.__dict__.get("name") == name:
                return value
        raise ExtensionError(f"{module.__file__} holds no {self.base} whose name is {name!r}")

    def _checked(self, name: str, value: Any) -> type[Any]:
        if not (isinstance(value, type) and issubclass(value, self.base_class)):
            raise ExtensionError(f"{self.title} {name!r} must derive from {self.room}.{self.base}")
        return value


@functools.cache  # parameters that change in flight ask for names again and again
def _own_names(room: str) -> list[str]:
    folder = PACKAGE.joinpath(*room.split(".")[1:])
    return sorted(path.stem for path in folder.glob("*.py") if path.stem[0] != "_")


@functools.cache  # it looks into every package that is installed
def entry_points(group: str) -> tuple[metadata.EntryPoint, ...]:
    """Entry points of a group, looked up once.

    Args:
        group: Its name.
    """
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
    # Under one name in every process, so that what is defined there can be pickled.
    name = f"extension_{path.stem}"
    present = sys.modules.get(name)
    if present is not None and present.__file__ == str(path):
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


GUIDANCE_LAW = Kind("guidance law", "uav_tracking_mpc.laws", "GuidanceLaw")
LIMIT = Kind("limit", "uav_tracking_mpc.limits", "Limit")
RELATIVE_MODEL = Kind(
    "prediction model", "uav_tracking_mpc.dynamics.relative_models", "RelativeModel"
)
VEHICLE_MODEL = Kind(
    "model of the vehicle", "uav_tracking_mpc.dynamics.vehicle_models", "VehicleModel"
)
PLANT = Kind("plant", "uav_tracking_mpc.simulation.plants", "Plant")
TARGET_MOTION = Kind("target motion", "uav_tracking_mpc.simulation.motions", "TargetMotion")
VEHICLE_LINK = Kind("vehicle link", "uav_tracking_mpc.links", "VehicleLink")
FAULT = Kind("fault", "uav_tracking_mpc.studies.faults.kinds", "Fault")
SCENE_ELEMENT = Kind("element of the scene", "uav_tracking_mpc.view.scene", "SceneElement")
PANEL_PART = Kind("part of the panel", "uav_tracking_mpc.view.panel", "PanelPart")
