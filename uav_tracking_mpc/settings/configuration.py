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

"""A configuration: one YAML file for all nodes, in the form that ROS 2 reads."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml

from uav_tracking_mpc.parameters.registry import did_you_mean
from uav_tracking_mpc.parameters.specification import ParameterError, Parameters, from_mapping
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.settings.simulator import (
    MissionParameters,
    ScenarioParameters,
    SimulatorParameters,
    TargetParameters,
)
from uav_tracking_mpc.settings.tracking import TrackingParameters

Sections = dict[str, dict[str, Any]]


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Numbers as YAML 1.2 and people write them: 1e3 is one, 1:30 is none. A key stands once.

    By libyaml where PyYAML was built with it, which is faster. ``ros2 launch`` writes the arrays of
    a launch file as tuples of Python, which ROS reads as any sequence.
    """

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """A mapping; PyYAML would take the last of several values without a word.

        Args:
            node: Of the mapping.
            deep: As of PyYAML.

        Raises:
            yaml.YAMLError: A key stands there twice.
        """
        lines = dict[tuple[str, str], int]()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            name, line = (key.tag, key.value), key.start_mark.line + 1
            if name in lines:
                words = f"'{key.value}' is given twice, in line {lines[name]} and in line {line}"
                raise yaml.YAMLError(words)
            lines[name] = line
        return dict(super().construct_mapping(node, deep))


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
_Loader.add_constructor("tag:yaml.org,2002:python/tuple", _Loader.construct_sequence)


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
        if unnamed := [name for name in values if not isinstance(name, str)]:
            raise ParameterError(
                f"configuration {path}: section '{key}': {unnamed[0]!r} is no name of a parameter"
            )
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
        return read_value(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError(f"{kind} {path} cannot be read: {error}") from error


def read_value(text: str) -> Any:
    """A value in YAML.

    Args:
        text: Of the value.

    Raises:
        yaml.YAMLError: It is none.
    """
    try:
        return yaml.load(text, _Loader)
    except (ValueError, KeyError, AttributeError, RecursionError) as error:
        # Of a date that is none, an integer of thousands of digits, a tag of something else, ...
        raise yaml.YAMLError(f"a value cannot be read: {error}") from error


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


T = TypeVar("T", bound=Parameters)

SECTIONS: dict[str, type[Parameters]] = {
    "nmpc_controller": TrackingParameters,
    "uav_simulator": SimulatorParameters,
    "target_publisher": TargetParameters,
    "autopilot_link": LinkParameters,
    "mission": MissionParameters,
}
SCENARIO = "scenario"  # the section that only files of scenarios have


@dataclass(frozen=True)
class Configuration:
    """Parameters of every node, checked.

    Attributes:
        name: Name of the file without its ending.
        controller: Section ``nmpc_controller``.
        simulator: Section ``uav_simulator``.
        target: Section ``target_publisher``.
        link: Section ``autopilot_link``.
        mission: Section ``mission``.
        sections: The values as they stood in the files, with overrides, by section.
        scenario: Section ``scenario`` of the scenario, None without one.
        changes: What changes in a simulated flight: times in [s], in order, and overrides as
            ``SECTION.PARAMETER=VALUE``.
    """

    name: str
    controller: TrackingParameters
    simulator: SimulatorParameters
    target: TargetParameters
    link: LinkParameters
    mission: MissionParameters
    sections: Sections = field(default_factory=dict)
    scenario: ScenarioParameters | None = None
    changes: tuple[tuple[float, str], ...] = ()

    def yaml(self) -> str:
        """The configuration as a ROS 2 parameter file for nodes in any namespace."""
        return parameter_file(self.sections)

    def changed(self, section: str, values: Mapping[str, Any]) -> Configuration:
        """This configuration with other values in a section.

        Args:
            section: Name of the node, or ``mission``.
            values: By parameter.

        Raises:
            ParameterError: As of :func:`configuration_of`.
        """
        sections = {**self.sections, section: {**self.sections[section], **values}}
        return replace(configuration_of(self.name, sections, self.scenario), changes=self.changes)


def configuration_folder() -> Path:
    """Where the configurations that come with the package lie."""
    installed = Path(str(resources.files("uav_tracking_mpc"))) / "config"
    return installed if installed.is_dir() else installed.parents[1] / "config"


def configuration_names() -> list[str]:
    """Names of the configurations that come with the package."""
    return _names(configuration_folder())


def scenario_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    return _names(configuration_folder() / "scenarios")


def campaign_names() -> list[str]:
    """Names of the campaigns that come with the package."""
    return _names(configuration_folder() / "campaigns")


def _names(folder: Path) -> list[str]:
    return sorted(path.stem for path in folder.glob("*.yaml"))


def load_configuration(
    name_or_file: str, overrides: Iterable[str] = (), scenario: str | None = None
) -> Configuration:
    """Load a configuration by name, or from a file.

    Args:
        name_or_file: Name of one that comes with the package, or path of a YAML file.
        overrides: ``SECTION.PARAMETER=VALUE`` each, VALUE in YAML; they win over all files.
        scenario: Name of one that comes with the package, or path of a YAML file: sections whose
            values replace those of the configuration, and ``scenario``.

    Raises:
        ParameterError: No such configuration or scenario, not readable as YAML, an unknown section
            or parameter, a value that is not allowed.
    """
    if isinstance(overrides, str):
        raise ParameterError(f"overrides are {overrides!r}, must be a list of such words")
    return configuration_of(*chosen_sections(name_or_file, overrides, scenario))


def chosen_sections(
    name_or_file: str, overrides: Iterable[str] = (), scenario: str | None = None
) -> tuple[str, Sections, ScenarioParameters | None]:
    """Name, values by section and scenario of a configuration, its values not checked yet.

    Args:
        name_or_file: As of :func:`load_configuration`.
        overrides: As of :func:`load_configuration`.
        scenario: As of :func:`load_configuration`.

    Raises:
        ParameterError: No such configuration or scenario, not readable as YAML, an unknown section.
    """
    folder = configuration_folder()
    path = found("configuration", name_or_file, folder)
    sections = read_sections(path, SECTIONS)
    about = None
    if scenario is not None:
        overlay = found("scenario", scenario, folder / "scenarios")
        changes = read_sections(overlay, [*SECTIONS, SCENARIO])
        about = _built(ScenarioParameters, SCENARIO, changes.pop(SCENARIO))
        for section, values in changes.items():
            sections[section].update(values)
    for assignment in overrides:
        override(sections, assignment)
    return path.stem, sections, about


def configuration_of(
    name: str, sections: Sections, scenario: ScenarioParameters | None = None
) -> Configuration:
    """A configuration from values by section.

    Args:
        name: What it is called.
        sections: Values by parameter of every section.
        scenario: What the scenario is, if there is one.

    Raises:
        ParameterError: An unknown parameter, or a value that is not allowed.
    """
    built: dict[str, Any] = {
        section: _built(parameters, section, sections[section])
        for section, parameters in SECTIONS.items()
    }
    tracking, target = built["nmpc_controller"], built["target_publisher"]
    ground = (target.waypoints if target.motion == "waypoints" else target.position)[2]
    if refusal := tracking.envelope.refusal(tracking.orbit, np.zeros(3), ground):
        raise ParameterError(f"section 'nmpc_controller': {refusal}")
    return Configuration(
        name=name,
        controller=tracking,
        simulator=built["uav_simulator"],
        target=target,
        link=built["autopilot_link"],
        mission=built["mission"],
        sections=sections,
        scenario=scenario,
    )


def found(kind: str, name_or_file: str, folder: Path) -> Path:
    """File of that name in a folder of the package, or anywhere.

    Args:
        kind: What it is, for the message of an error.
        name_or_file: Name of one that comes with the package, or path of a YAML file.
        folder: Where those of the package lie.

    Raises:
        ParameterError: There is none.
    """
    names = _names(folder)
    if name_or_file in names:
        return folder / f"{name_or_file}.yaml"
    if not Path(name_or_file).is_file():
        raise ParameterError(
            f"{kind} is {name_or_file!r}{did_you_mean(name_or_file, names)}, must be a file or one "
            f"of {', '.join(names)}"
        )
    return Path(name_or_file)


def _built(parameters: type[T], section: str, values: Mapping[str, Any]) -> T:
    try:
        # A section of a node may hold rclpy's own parameter, too.
        return from_mapping(parameters, {k: v for k, v in values.items() if k != "use_sim_time"})
    except ParameterError as error:
        raise ParameterError(f"section '{section}': {error}") from error
