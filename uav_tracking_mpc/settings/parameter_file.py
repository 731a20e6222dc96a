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

"""Parameter files in the form that ROS 2 reads: sections of names and values, in YAML."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import yaml

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.parameters.suggestion import did_you_mean

Sections = dict[str, dict[str, Any]]


class _Loader(yaml.SafeLoader):
    """Numbers as YAML 1.2 and people write them: 1e3 is one, 1:30 is none."""


_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _NUMBERS]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(_NUMBERS[0], re.compile(r"[-+]?[0-9]+$"), list("-+0123456789"))
_Loader.add_implicit_resolver(
    _NUMBERS[1],
    re.compile(
        r"([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"
    ),
    list("-+0123456789."),
)


def read_sections(path: Path, known: Collection[str]) -> Sections:
    """Values by section and parameter; a section that the file does not have is empty.

    Args:
        path: YAML file whose sections are ``/**/NAME: {ros__parameters: {...}}``.
        known: Names that sections may have.

    Raises:
        ParameterError: Not readable as YAML, an unknown section, or one without parameters.
    """
    document = read_yaml(path, "configuration")
    if not isinstance(document, Mapping):
        raise ParameterError(f"configuration {path} holds no sections")
    sections: Sections = {section: {} for section in known}
    for key, content in document.items():
        section = str(key).rsplit("/", 1)[-1]
        if section not in known:
            raise ParameterError(
                f"configuration {path}: section '{key}' is unknown{did_you_mean(section, known)}, "
                f"known are: {', '.join(known)}"
            )
        values = content.get("ros__parameters") if isinstance(content, Mapping) else None
        if not isinstance(values, Mapping):
            raise ParameterError(f"configuration {path}: section '{key}' has no ros__parameters")
        sections[section].update(values)
    return sections


def read_yaml(path: Path, kind: str) -> Any:
    """Content of a YAML file, with numbers as people write them.

    Args:
        path: Of the file.
        kind: What it is, for the message of an error.

    Raises:
        ParameterError: Not readable as YAML.
    """
    try:
        return yaml.load(path.read_text(encoding="utf-8"), _Loader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError(f"{kind} {path} cannot be read: {error}") from error


def read_value(text: str) -> Any:
    """A value in YAML.

    Args:
        text: Of the value.

    Raises:
        yaml.YAMLError: It is none.
    """
    return yaml.load(text, _Loader)


def override(sections: Sections, assignment: str) -> None:
    """Replace one value.

    Args:
        sections: Changed in place.
        assignment: ``SECTION.PARAMETER=VALUE``, VALUE in YAML.

    Raises:
        ParameterError: It has another form, its section is unknown, or the value is not YAML.
    """
    name, equals, text = assignment.partition("=")
    section, dot, parameter_name = name.strip().partition(".")
    if not (equals and dot and section in sections and parameter_name):
        raise ParameterError(
            f"override is {assignment!r}{did_you_mean(section, sections) if dot else ''}, must be "
            "SECTION.PARAMETER=VALUE with SECTION one of "
            f"{', '.join(sections)}"
        )
    try:
        sections[section][parameter_name] = read_value(text)
    except yaml.YAMLError as error:
        raise ParameterError(f"override {assignment!r} is not YAML: {error}") from error


def parameter_file(sections: Sections) -> str:
    """Text of a parameter file for nodes in any namespace.

    Args:
        sections: Values by section and parameter; empty sections are left out.
    """
    document = {
        f"/**/{section}": {"ros__parameters": values}
        for section, values in sections.items()
        if values
    }
    return yaml.safe_dump(document, sort_keys=False)
