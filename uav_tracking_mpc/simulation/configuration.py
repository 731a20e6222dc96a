"""A configuration: one YAML file for all nodes, in the form that ROS 2 reads."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.parameters import ParameterError, from_mapping, parameter
from uav_tracking_mpc.simulation.simulator_parameters import SimulatorParameters
from uav_tracking_mpc.simulation.target_motion import TargetParameters


@dataclass(frozen=True)
class MissionParameters:
    """What `fly` and `simulate` add to the nodes: how long, how fast, on which plant."""

    duration: float = parameter(
        150.0, "Length of the mission, simulated time.", unit="s", lower=1.0, upper=1e6
    )
    speed: float = parameter(10.0, "Simulated over wall time in fly.", lower=0.01, upper=100.0)
    plant: str = parameter(
        "vehicle",
        "What simulate flies: the exact vehicle, or the prediction model by Euler's method, which "
        "knows no wind, lag or noise.",
        choices=("vehicle", "euler"),
    )


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


SECTIONS: dict[str, type] = {
    "nmpc_controller": TrackingParameters,
    "uav_simulator": SimulatorParameters,
    "target_publisher": TargetParameters,
    "mission": MissionParameters,
}


@dataclass(frozen=True)
class Configuration:
    """Parameters of every node, checked.

    Attributes:
        name: Name of the file without its ending.
        controller: Section ``nmpc_controller``.
        simulator: Section ``uav_simulator``.
        target: Section ``target_publisher``.
        mission: Section ``mission``.
        sections: The values as they stood in the file, with overrides, by section.
    """

    name: str
    controller: TrackingParameters
    simulator: SimulatorParameters
    target: TargetParameters
    mission: MissionParameters
    sections: dict[str, dict[str, Any]] = field(default_factory=dict)

    def yaml(self) -> str:
        """The configuration as a ROS 2 parameter file for nodes in any namespace."""
        document = {
            f"/**/{section}": {"ros__parameters": values}
            for section, values in self.sections.items()
            if values
        }
        return yaml.safe_dump(document, sort_keys=False)


def configuration_folder() -> Path:
    """Where the configurations that come with the package lie."""
    installed = Path(str(resources.files("uav_tracking_mpc"))) / "config"
    return installed if installed.is_dir() else installed.parents[1] / "config"


def configuration_names() -> list[str]:
    """Names of the configurations that come with the package."""
    return sorted(path.stem for path in configuration_folder().glob("*.yaml"))


def load_configuration(name_or_file: str, overrides: Iterable[str] = ()) -> Configuration:
    """Load a configuration by name, or from a file.

    Args:
        name_or_file: Name of one that comes with the package, or path of a YAML file.
        overrides: ``SECTION.PARAMETER=VALUE`` each, VALUE in YAML.

    Raises:
        ParameterError: No such configuration, not readable as YAML, an unknown section or
            parameter, a value that is not allowed.
    """
    path = Path(name_or_file)
    if name_or_file in configuration_names():
        path = configuration_folder() / f"{name_or_file}.yaml"
    elif not path.is_file():
        raise ParameterError(
            f"configuration is {name_or_file!r}, must be a file or one of "
            f"{', '.join(configuration_names())}"
        )
    try:
        sections = _sections(yaml.load(path.read_text(encoding="utf-8"), _Loader), path)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError(f"configuration {path} cannot be read: {error}") from error
    for override in overrides:
        _override(sections, override)
    built: dict[str, Any] = {}
    for section, parameters in SECTIONS.items():
        values = {k: v for k, v in sections[section].items() if k != "use_sim_time"}
        try:
            built[section] = from_mapping(parameters, values)
        except ParameterError as error:
            raise ParameterError(f"section '{section}': {error}") from error
    return Configuration(
        name=path.stem,
        controller=built["nmpc_controller"],
        simulator=built["uav_simulator"],
        target=built["target_publisher"],
        mission=built["mission"],
        sections=sections,
    )


def _sections(document: Any, path: Path) -> dict[str, dict[str, Any]]:
    sections: dict[str, dict[str, Any]] = {section: {} for section in SECTIONS}
    if not isinstance(document, Mapping):
        raise ParameterError(f"configuration {path} holds no sections")
    for key, content in document.items():
        section = str(key).rsplit("/", 1)[-1]
        if section not in SECTIONS:
            raise ParameterError(
                f"configuration {path}: section '{key}' is unknown, known are: "
                f"{', '.join(SECTIONS)}"
            )
        values = content.get("ros__parameters") if isinstance(content, Mapping) else None
        if not isinstance(values, Mapping):
            raise ParameterError(f"configuration {path}: section '{key}' has no ros__parameters")
        sections[section].update(values)
    return sections


def _override(sections: dict[str, dict[str, Any]], override: str) -> None:
    name, equals, text = override.partition("=")
    section, dot, parameter_name = name.strip().partition(".")
    if not (equals and dot and section in SECTIONS and parameter_name):
        raise ParameterError(
            f"override is {override!r}, must be SECTION.PARAMETER=VALUE with SECTION one of "
            f"{', '.join(SECTIONS)}"
        )
    try:
        sections[section][parameter_name] = yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        raise ParameterError(f"override {override!r} is not YAML: {error}") from error
