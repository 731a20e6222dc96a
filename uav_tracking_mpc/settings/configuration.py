"""A configuration: one YAML file for all nodes, in the form that ROS 2 reads."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import yaml

from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping, parameter
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.target_motion import TargetParameters

T = TypeVar("T")


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


@dataclass(frozen=True)
class ScenarioParameters:
    """What a scenario is; no node reads it."""

    title: str = parameter("", "What it is called.")
    description: str = parameter("", "What happens in it.")


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
SCENARIO = "scenario"  # the section that only files of scenarios have


@dataclass(frozen=True)
class Configuration:
    """Parameters of every node, checked.

    Attributes:
        name: Name of the file without its ending.
        controller: Section ``nmpc_controller``.
        simulator: Section ``uav_simulator``.
        target: Section ``target_publisher``.
        mission: Section ``mission``.
        sections: The values as they stood in the files, with overrides, by section.
        scenario: Section ``scenario`` of the scenario, None without one.
    """

    name: str
    controller: TrackingParameters
    simulator: SimulatorParameters
    target: TargetParameters
    mission: MissionParameters
    sections: dict[str, dict[str, Any]] = field(default_factory=dict)
    scenario: ScenarioParameters | None = None

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


def scenario_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    return sorted(path.stem for path in (configuration_folder() / "scenarios").glob("*.yaml"))


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
    folder = configuration_folder()
    path = _find("configuration", name_or_file, folder, configuration_names())
    sections = _read(path, SECTIONS)
    about = None
    if scenario is not None:
        overlay = _find("scenario", scenario, folder / "scenarios", scenario_names())
        changes = _read(overlay, [*SECTIONS, SCENARIO])
        about = _built(ScenarioParameters, SCENARIO, changes.pop(SCENARIO))
        for section, values in changes.items():
            sections[section].update(values)
    for override in overrides:
        _override(sections, override)
    built: dict[str, Any] = {}
    for section, parameters in SECTIONS.items():
        values = {k: v for k, v in sections[section].items() if k != "use_sim_time"}
        built[section] = _built(parameters, section, values)
    return Configuration(
        name=path.stem,
        controller=built["nmpc_controller"],
        simulator=built["uav_simulator"],
        target=built["target_publisher"],
        mission=built["mission"],
        sections=sections,
        scenario=about,
    )


def _find(kind: str, name_or_file: str, folder: Path, names: list[str]) -> Path:
    if name_or_file in names:
        return folder / f"{name_or_file}.yaml"
    if not Path(name_or_file).is_file():
        raise ParameterError(
            f"{kind} is {name_or_file!r}, must be a file or one of {', '.join(names)}"
        )
    return Path(name_or_file)


def _read(path: Path, known: Collection[str]) -> dict[str, dict[str, Any]]:
    try:
        return _sections(yaml.load(path.read_text(encoding="utf-8"), _Loader), path, known)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError(f"configuration {path} cannot be read: {error}") from error


def _built(parameters: type[T], section: str, values: Mapping[str, Any]) -> T:
    try:
        return from_mapping(parameters, values)
    except ParameterError as error:
        raise ParameterError(f"section '{section}': {error}") from error


def _sections(document: Any, path: Path, known: Collection[str]) -> dict[str, dict[str, Any]]:
    sections: dict[str, dict[str, Any]] = {section: {} for section in known}
    if not isinstance(document, Mapping):
        raise ParameterError(f"configuration {path} holds no sections")
    for key, content in document.items():
        section = str(key).rsplit("/", 1)[-1]
        if section not in known:
            raise ParameterError(
                f"configuration {path}: section '{key}' is unknown, known are: {', '.join(known)}"
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
