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

"""A parser whose help shows every default, and whose errors say what may have been meant."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.parameters.suggestion import did_you_mean


class HelpFormatter(argparse.HelpFormatter):
    """Help that shows the default of every option that takes a value."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        words, default = action.help or "", action.default
        takes_value = action.option_strings and action.nargs != 0
        if not takes_value or "default" in words or default == []:
            return words
        if default in (None, ""):
            return f"{words} (default: none)"
        if isinstance(default, (list, tuple)):
            return f"{words} (default: {' '.join(str(item) for item in default)})"
        return f"{words} (default: %(default)s)"


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
