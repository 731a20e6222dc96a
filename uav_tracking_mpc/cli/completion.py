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

"""What the shell offers at the Tab key: commands, options, and the names that options take.

It needs the library argcomplete and a line in the shell's start file, see
docs/reference/command_line.md; without either nothing happens. A completion must come at once: it
imports no solver.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import ModuleType
from typing import Any

ASKED = "_ARGCOMPLETE"  # set by the shell while it asks


def offer(make_parser: Callable[[Sequence[str]], argparse.ArgumentParser]) -> None:
    """Answer the shell and end the process, if it is the shell that asks.

    Args:
        make_parser: Makes the parser of the words of a command line, without the program's.
    """
    if ASKED not in os.environ:
        return
    try:
        import argcomplete
        from argcomplete.lexers import split_line
    except ImportError:
        return
    _import_when_used("casadi")
    line, point = os.environ.get("COMP_LINE", ""), int(os.environ.get("COMP_POINT", 0))
    words = split_line(line, point)[3]
    parser = make_parser(words[int(os.environ[ASKED]) :])  # its value counts the program's words
    for action in _actions(parser):
        names = _names(action)
        if names is not None:
            action.completer = names  # type: ignore[attr-defined]
    argcomplete.autocomplete(parser)


def settings(prefix: str) -> Iterator[str]:
    """``SECTION.PARAMETER=`` of every parameter; behind the ``=`` the names that it may have.

    Args:
        prefix: What is typed so far.
    """
    from uav_tracking_mpc.parameters.specification import specifications
    from uav_tracking_mpc.settings.configuration import SECTIONS

    name, equals, _ = prefix.partition("=")
    for section, parameters in SECTIONS.items():
        for known in specifications(parameters):
            key = f"{section}.{known.name}"
            if not equals:
                yield f"{key}="
            elif key == name:
                values = [*known.choices, *(known.extension.names if known.extension else ())]
                if isinstance(known.default, bool):
                    values = ["true", "false"]
                yield from (f"{key}={value}" for value in values)


def _import_when_used(name: str) -> None:
    """Put off the import of a package whose functions no list of names calls.

    The descriptions of the parameters stand beside equations, whose library takes longer to import
    than a completion may take.
    """

    def attribute(wanted: str) -> Any:
        if wanted.startswith("__"):
            raise AttributeError(wanted)
        del sys.modules[name]
        return getattr(importlib.import_module(name), wanted)

    later = ModuleType(name)
    later.__getattr__ = attribute  # type: ignore[method-assign]
    sys.modules.setdefault(name, later)


def _configurations() -> Iterable[str]:
    from uav_tracking_mpc.settings.configuration import configuration_names

    return configuration_names()


def _scenarios() -> Iterable[str]:
    from uav_tracking_mpc.settings.configuration import scenario_names

    return scenario_names()


def _campaigns() -> Iterable[str]:
    from uav_tracking_mpc.settings.configuration import campaign_names

    return campaign_names()


def _extensions(kind: str) -> Callable[[], Iterable[str]]:
    def names() -> Iterable[str]:
        from uav_tracking_mpc.parameters import registry

        found: registry.Kind = getattr(registry, kind)
        return found.names

    return names


NAMES: dict[str, Callable[[], Iterable[str]]] = {
    "--config": _configurations,
    "--scenario": _scenarios,
    "campaign": _campaigns,
    "--law": _extensions("GUIDANCE_LAW"),
    "--plant": _extensions("PLANT"),
    "--limit": _extensions("LIMIT"),
    "--link": _extensions("VEHICLE_LINK"),
}


def _names(action: argparse.Action) -> Callable[..., Iterable[str]] | None:
    """What gives the names that an argument takes; None where argcomplete knows better."""
    if action.choices is not None:
        return None
    if action.metavar == "SECTION.PARAMETER=VALUE":
        return lambda prefix, **_: settings(prefix)
    names = NAMES.get(action.option_strings[0] if action.option_strings else action.dest)
    return None if names is None else lambda **_: names()


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Arguments of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
