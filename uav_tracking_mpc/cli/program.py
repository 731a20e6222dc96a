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

"""What the commands share: parser, completion, printing and writing, and how one that failed ends.

The shell is offered commands, options, and the names that options take at the Tab key. That needs
the library argcomplete and a line in the shell's start file, see docs/reference/command_line.md;
without either nothing happens. A completion must come at once: it imports no solver.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.parameters.registry import did_you_mean, names_of
from uav_tracking_mpc.parameters.specification import ParameterError, specifications

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.study import Study


# That bring a module.
EXTRAS = {
    "distributed": "dask",
    "mcap": "view",
    "pyarrow": "campaign",
    "pymavlink": "mavlink",
    "viser": "view",
    "websockets": "view",
}
ROS_ENDINGS = ("rclpy", "_msgs", "_srvs", "_interfaces")


@dataclass
class Ending:
    """How a command ended.

    Attributes:
        code: Exit code: 0 done; 1 failed; 2 asked for what is not allowed, or something is missing
            that must be there before it can run at all; 3 flown but not settled (`fly`); 128 + n by
            signal n.
    """

    code: int = 0


@contextmanager
def explained(program: str) -> Iterator[Ending]:
    """Turn the errors that a command expects into one line and an exit code; others pass.

    Args:
        program: What the line begins with.
    """
    ending = Ending()
    try:
        yield ending
    except BrokenPipeError:  # as of `| head`: nobody reads on, which is no error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        ending.code = 128 + signal.SIGPIPE
    except (Exception, KeyboardInterrupt) as error:
        found = explanation(error)
        if found is None:
            raise
        ending.code, message = found
        print(f"{program}: {message}", file=sys.stderr)


def explanation(error: BaseException) -> tuple[int, str] | None:
    """Exit code and message of an error, or None where it is none that a command expects.

    Args:
        error: What was raised.
    """
    if isinstance(error, KeyboardInterrupt):
        return 128 + signal.SIGINT, "interrupted"
    if isinstance(error, ImportError):
        return _missing(error)
    # Only now: what raises these errors takes longer to import than help takes to print.
    from uav_tracking_mpc.launch.flight import FlightInterruptedError
    from uav_tracking_mpc.launch.supervisor import LaunchError
    from uav_tracking_mpc.links import LinkError
    from uav_tracking_mpc.mpc.compiled_method import CompilationError
    from uav_tracking_mpc.nodes.ros.ros_environment import DomainValueError, refusal_of_ros
    from uav_tracking_mpc.parameters.registry import ExtensionError
    from uav_tracking_mpc.simulation.closed_loop import SimulationError
    from uav_tracking_mpc.studies.executors import WorkerError

    if isinstance(error, FlightInterruptedError):
        return 128 + error.signal, str(error)
    if isinstance(error, (ParameterError, ExtensionError, LinkError, DomainValueError)):
        return 2, str(error)
    expected = (LaunchError, SimulationError, WorkerError, CompilationError, OSError)
    if isinstance(error, expected):
        return 1, str(error)
    refused = refusal_of_ros(error)
    return (2, refused) if refused else None


def _missing(error: ImportError) -> tuple[int, str] | None:
    """A package that is not installed; a module of this one that is missing is a mistake in it."""
    if not isinstance(error, ModuleNotFoundError):
        return 2, str(error)
    if error.name is None or error.name.startswith("uav_tracking_mpc"):
        return None
    package = error.name.partition(".")[0]
    if package in EXTRAS:
        return 2, f"{package} is not installed: `pip install 'uav_tracking_mpc[{EXTRAS[package]}]'`"
    if not package.endswith(ROS_ENDINGS):
        return 2, f"{package} is not installed: `pip install uav_tracking_mpc` brings it"
    return 2, (
        f"{package} is not installed; flying needs ROS 2 Jazzy: source its setup file, or "
        "`pip install 'uav_tracking_mpc[ros]'`"
    )


class HelpFormatter(argparse.HelpFormatter):
    """Help that shows the default of every option that takes a value."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        words, default = action.help or "", action.default
        takes_value = action.option_strings and action.nargs != 0
        if not takes_value or "default" in words or default == []:
            return words
        shown = "none" if default in (None, "") else "%(default)s"
        if isinstance(default, (list, tuple)):
            shown = " ".join(map(str, default))
        return f"{words} (default: {shown})"


class CommandParser(argparse.ArgumentParser):
    """Parser of a command; those of its actions are of this class, too.

    Args:
        options: Of :class:`argparse.ArgumentParser`.
    """

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", HelpFormatter)
        super().__init__(**options)

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse, and refuse here what is unknown, where the usage of this very command is shown.

        Args:
            args: Command line; that of the process by default.
            namespace: Gets the values.
        """
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            wrong = next((word for word in unknown if word.startswith("-")), unknown[0])
            meant = did_you_mean(wrong.partition("=")[0], self._option_string_actions)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += did_you_mean(value, action.choices or ())
            raise


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


def publish(study: Study, arguments: argparse.Namespace) -> int:
    """Write what a study found where the options say, and print it.

    Args:
        study: What was found.
        arguments: With ``output`` and ``json``, of some commands with ``page``.

    Returns:
        Exit code.
    """
    answer(study.content, study.publish(arguments.output), arguments.json)
    if getattr(arguments, "page", None) is not None:
        study.document(arguments.page)
    if study.left:
        print(f"interrupted: {study.left}", file=sys.stderr)
        return 128 + signal.SIGINT
    return 0 if study.good else 1


def check_writable(folder: Path) -> None:
    """Make sure that files can be written into a folder; nothing of the trial is left behind.

    Args:
        folder: That will be written; it need not be there yet.

    Raises:
        ParameterError: They cannot be.
    """
    import tempfile

    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = "it is a file" if folder.is_file() else error.strerror or str(error)
        raise ParameterError(
            f"--output is {str(folder)!r}, must be a folder that can be written: {reason}"
        ) from error
    finally:
        for made in missing:
            if made.is_dir():
                made.rmdir()


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
    argcomplete.autocomplete(parser, default_completer=_names)  # type: ignore[arg-type]


def settings(prefix: str) -> Iterator[str]:
    """``SECTION.PARAMETER=`` of every parameter; behind the ``=`` the names that it may have.

    Args:
        prefix: What is typed so far.
    """
    from uav_tracking_mpc.settings.configuration import SECTIONS

    name, equals, _ = prefix.partition("=")
    for section, parameters in SECTIONS.items():
        for known in specifications(parameters):
            key = f"{section}.{known.name}"
            if not equals:
                yield f"{key}="
            elif key == name:
                values = ("true", "false") if isinstance(known.default, bool) else known.names
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


# Functions that list names, and rooms whose files have them, by the option or argument that takes
# one of them.
LISTS = {
    "--config": "configuration_names",
    "--scenario": "scenario_names",
    "campaign": "campaign_names",
}
ROOMS = {"--law": "laws", "--plant": "simulation.plants", "--limit": "limits", "--link": "links"}


def _names(prefix: str, action: argparse.Action, **asked: Any) -> Iterable[str]:
    """The names that an argument takes, or files."""
    from argcomplete.completers import FilesCompleter

    name = action.option_strings[0] if action.option_strings else action.dest
    if name == "--set":
        return settings(prefix)
    if name in ROOMS:
        return names_of(f"uav_tracking_mpc.{ROOMS[name]}")
    if name in LISTS:
        from uav_tracking_mpc.settings import configuration

        return getattr(configuration, LISTS[name])()  # type: ignore[no-any-return]
    return FilesCompleter()(prefix, action=action, **asked)  # type: ignore[no-any-return]
