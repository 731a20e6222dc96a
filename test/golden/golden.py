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

"""Fly again what the records of this folder hold, and say what differs: ``make golden``.

The imports from the package and the commands below are all that it needs of the product; where a
refactoring moves one of them, only its name is changed here.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from comparison import Difference, amplified, differences
from rosbags.rosbag2 import Reader

from uav_tracking_mpc import FlightLog, load_configuration
from uav_tracking_mpc.control.record import RecordingController
from uav_tracking_mpc.nodes.bag_log import flight_log
from uav_tracking_mpc.report.metrics import metrics
from uav_tracking_mpc.settings.configuration import scenario_names
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.studies.comparison.scenarios import (
    MISMATCHES,
    SENSOR_FAULTS,
    law_names,
    mismatched,
)
from uav_tracking_mpc.studies.executors import parallel_map

FOLDER = Path(__file__).parent / "records"
CONFIGURATIONS = ("paper", "small_uav", "jsbsim_uav")
COMPILERS = ("numpy", "casadi", "numba", "jsbsim", "scipy")  # whose versions may change a bit
WORKERS = 2
FLIGHT, MISMATCHED = 30.0, 15.0  # s: the turn onto the orbit
# m: where a record differs its flight begins again that far beside, to see what a last bit does
BESIDE = (1e-7, -1e-7, 3e-8, -3e-8, 1e-8, -1e-8)
EVERY = 2.0  # s from sample to sample; digests and spans are of all of them
RAISED = "raised"  # key of what failed
# No load of the machine decides which plan is flown.
PATIENT = "nmpc_controller.solve_time_max=10.0"
SHORT = ("--set", "mission.duration=10", "--json")
COMMAND = "import sys; from uav_tracking_mpc.cli.main import main; sys.exit(main())"
STOPPED = "import time; time.perf_counter = lambda: 0.0; "  # no proof runs out of time
# Of each kind of row one: all of them fly one by one below.
ROWS = ("lag_2", "gust_light", "zigzag", "airspeed_zero", "position_jumps", "dropout_circling")
HELD = ("wind", "gusts")  # scenarios of an autopilot that holds altitude and airspeed
COMMANDS: dict[str, tuple[str, ...]] = {
    **{f"compare {name}": ("compare", "--config", name, *SHORT) for name in CONFIGURATIONS},
    "compare --mismatch": ("compare", "--mismatch", *ROWS, *SHORT),
    **{f"stability {name}": ("stability", "--config", name, "--json") for name in CONFIGURATIONS},
    **{f"margins {name}": ("margins", "--config", name, "--json") for name in CONFIGURATIONS},
    "benchmark": ("benchmark", "--quick", "--cold", "2", "--peers-cold", "1", "--json"),
}  # fmt: skip
# Made once, by `uav_tracking fly` with these settings: what was recorded with one release is read
# by all that follow, so it is not made anew.
BAG = FOLDER / "mission.mcap"
SETTINGS = (
    "--config", "small_uav", "--scenario", "crosswind",
    "--set", "mission.duration=4.0", "--set", "mission.speed=5.0",
)  # fmt: skip
STATES = ("x [m]", "y [m]", "z [m]", "heading [rad]", "path angle [rad]", "airspeed [m/s]")
INPUTS = ("turn rate [rad/s]", "path angle rate [rad/s]", "acceleration [m/s^2]")


def names() -> list[str]:
    """Of all records, the longest work first."""
    kinds = [(f"scenario {name}", law) for name in scenario_names() for law in law_names()]
    kinds += [
        (f"mismatch {name}", law)
        for name in MISMATCHES
        for law in ([PREDICTIVE] if name in SENSOR_FAULTS else law_names())
    ]
    flights = [
        f"{config}: {kind}: {law}"
        for config in CONFIGURATIONS
        for kind, law in kinds
        if not (config == "paper" and kind.partition(" ")[2] in SENSOR_FAULTS)  # slower than wind
    ]
    flights += [f"small_uav: held {name}: {PREDICTIVE}" for name in HELD]
    missions = [f"{config}: mission: {law}" for config in CONFIGURATIONS for law in law_names()]
    missions += [f"{config}: simulate" for config in CONFIGURATIONS]
    return [*COMMANDS, "fly", *missions, *flights, "bag"]


def record(name: str, beside: float = 0.0) -> Any:
    """What the product does now; what it raises is another behaviour, and the rest flies on.

    Args:
        name: One of :func:`names`.
        beside: By how much the aircraft begins further east in [m], where it can.
    """
    try:
        return _content(name, beside)
    except Exception as error:
        return {RAISED: f"{type(error).__name__}: {error}"}


def _content(name: str, beside: float) -> Any:
    if name in COMMANDS:
        content = json.loads(_run(*COMMANDS[name]))
        content = _keys(content) if name == "benchmark" else content
    elif name == "fly":
        content = _flown(*SETTINGS)
    elif name.endswith(": simulate"):
        content = _reported("--config", name.partition(":")[0], "--set", PATIENT)
    elif name == "bag":
        log = flight_log(BAG, load_configuration("small_uav", SETTINGS[5::2], "crosswind"))
        content = {"metrics": metrics(log), **_flight(log)}
    else:
        content = _simulated(*name.split(": "), beside)
    return json.loads(json.dumps(content), parse_constant=str)


def _simulated(config: str, kind: str, law: str, beside: float) -> dict[str, Any]:
    """Fly without ROS; the record of the controller is that of a node, without wall times."""
    told = [f"nmpc_controller.law={law}", PATIENT]
    if beside:
        east, *rest = load_configuration(config).simulator.initial_position
        told.append(f"uav_simulator.initial_position={[east + beside, *rest]}")
    kind, _, name = kind.partition(" ")
    if config == "paper" and kind != "mission":
        told.append("mission.plant=vehicle")  # the Euler plant knows neither wind nor motion
    if kind == "held":
        told += ["mission.plant=held", "nmpc_controller.autopilot_holds=true"]
    told.append(f"mission.duration={MISMATCHED if kind == 'mismatch' else FLIGHT}")
    if kind == "mismatch":
        configuration = mismatched(config, name, tuple(told))
    else:
        configuration = load_configuration(config, told, name or None)
    loop, duration = ClosedLoop(configuration), configuration.mission.duration
    with tempfile.TemporaryDirectory() as folder:
        path, replaced = Path(folder) / "controller.jsonl", loop.controller
        loop.controller = RecordingController(
            replaced.parameters, path, replaced.formulation, stopwatch=lambda: 0.0
        )
        for _ in range(round(duration * loop.rate)):
            loop.tick()
        loop.controller.close()
        _, *calls = path.read_bytes().splitlines()  # the header holds parameters and version
    log = loop.log(duration)
    return {"controller.jsonl digest": _digest(*calls), **_flight(log)}


def _flight(log: FlightLog) -> dict[str, Any]:
    """Digest and span of all states and commands, and some of them."""
    latest = np.searchsorted(log.command_time, log.time + 1e-9, side="right") - 1
    columns = dict(zip(STATES, log.vehicle.T, strict=True))
    held = zip((*INPUTS, "cost"), (*log.inputs.T, log.cost), strict=True)
    columns |= {name: np.where(latest < 0, np.nan, values[latest]) for name, values in held}
    columns = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    thin = slice(None, None, max(1, round(EVERY * (len(log.time) - 1) / np.ptp(log.time))))
    arrays = (log.time, log.vehicle, log.target, log.command_time, log.inputs, log.cost)
    return {
        "flight digest": _digest(*(np.ascontiguousarray(array).tobytes() for array in arrays)),
        "states": len(log.time),
        "commands": len(log.command_time),
        "failures": log.failures,
        "modes": [{"from [s]": m.time, "mode": m.mode.value, "why": m.reason} for m in log.modes],
        "least, greatest, mean": {
            name: [float(of(values)) for of in (np.nanmin, np.nanmax, np.nanmean)]
            for name, values in columns.items()
        },
        f"every {EVERY:g} s": {name: values[thin].tolist() for name, values in columns.items()},
    }


def _reported(*words: str) -> dict[str, Any]:
    """What the command ``simulate`` leaves in its folder."""
    with tempfile.TemporaryDirectory() as name:
        _run("simulate", *words, "--output", name)
        page = _Page()
        page.feed((Path(name) / "report.html").read_text())
        return {
            "files": sorted(path.name for path in Path(name).iterdir()),
            "metrics": json.loads((Path(name) / "metrics.json").read_text()),
            "report": page.parts,
        }


def _flown(*words: str) -> dict[str, Any]:
    """What the command ``fly`` leaves in its folder: only what no load of the machine decides."""
    with tempfile.TemporaryDirectory() as name:
        _run("fly", *words, "--output", name, allowed=(0, 3))
        calls: dict[str, set[str]] = {"see_target": set(), "step": set()}
        with (Path(name) / "controller.jsonl").open() as file:
            header = json.loads(next(file))
            for call in map(json.loads, file):
                calls.get(call["call"], set()).update(call)
        with Reader(Path(name) / "mission.mcap") as bag:
            topics = {
                each.topic: [each.msgtype, *map(_quality, each.ext.offered_qos_profiles)]
                for each in bag.connections
            }
        return {
            "files": sorted(path.name for path in Path(name).iterdir()),
            "topics": topics,
            "controller.jsonl": {
                "header": _keys(header),
                **{k: sorted(v) for k, v in calls.items()},
            },
        }


def _quality(profile: Any) -> str:
    kinds = (profile.reliability, profile.durability, profile.history)
    return f"{' '.join(kind.name for kind in kinds)} {profile.depth}"


class _Page(HTMLParser):
    """Headings, names of rows and columns, figures of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.parts: list[str] = []
        self._inside = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = tag if tag in ("h1", "h2", "h3", "th", "summary") else self._inside
        if tag == "img":
            self.parts.append(f"figure: {dict(attrs).get('alt')}")

    def handle_endtag(self, tag: str) -> None:
        self._inside = "" if tag == self._inside else self._inside

    def handle_data(self, data: str) -> None:
        if self._inside and data.strip():
            self.parts.append(f"{self._inside}: {' '.join(data.split())}")


def _run(*words: str, allowed: Sequence[int] = (0, 1)) -> str:
    """What a command prints for programs."""
    clock = STOPPED if words[0] == "stability" else ""
    program = [sys.executable, "-c", clock + COMMAND, *words]
    finished = subprocess.run(program, capture_output=True, text=True)
    if finished.returncode not in allowed:
        raise RuntimeError(f"uav_tracking {' '.join(words)}: {finished.stderr}")
    return finished.stdout


def _keys(content: Any) -> Any:
    """The names alone, with the type of what they hold."""
    if isinstance(content, dict):
        return {name: _keys(value) for name, value in content.items()}
    return type(content).__name__


def _digest(*parts: bytes) -> str:
    return hashlib.sha256(b"\n".join(parts)).hexdigest()


def _file(name: str) -> Path:
    config = name.split(":")[0]
    return FOLDER / f"{config if config in CONFIGURATIONS else 'commands'}.json"


def _write(found: dict[str, Any]) -> None:
    """One record a line."""
    for path in {_file(name): None for name in found}:
        lines = [
            f"{json.dumps(name)}: {json.dumps(content, separators=(',', ':'))}"
            for name, content in found.items()
            if _file(name) == path
        ]
        path.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def _read() -> dict[str, Any]:
    files = sorted(FOLDER.glob("*.json"))
    return {key: value for path in files for key, value in json.loads(path.read_text()).items()}


def _versions() -> dict[str, str]:
    return {name: version(name) for name in COMPILERS}


def _report(recorded: dict[str, Any], found: dict[str, Any]) -> Iterator[tuple[str, bool]]:
    """Lines about records that are not bit for bit the same, and whether they count as other."""
    for name in [*recorded, *(name for name in found if name not in recorded)]:
        pair = ({name: each[name]} if name in each else {} for each in (recorded, found))
        unlike = sorted(differences(*pair), key=lambda each: -each.size)
        beyond = [each for each in unlike if each.size > 1.0]
        if beyond and name in recorded and name in found and _can_begin_beside(name):
            twins = parallel_map(record, [(name, each) for each in BESIDE], WORKERS, name)
            beyond = amplified(beyond, {name: found[name]}, [{name: twin} for twin in twins])
            if not beyond:
                yield f"as other begins change it  {_in_short(unlike)}", False
                continue
        if unlike:
            said = "DIFFERS" if beyond else "within tolerance"
            yield f"{said}  {_in_short(beyond or unlike)}", bool(beyond)


def _can_begin_beside(name: str) -> bool:
    """Whether a record is of a flight that is simulated here."""
    return name.split(": ")[0] in CONFIGURATIONS and not name.endswith(": simulate")


def _in_short(unlike: list[Difference]) -> str:
    """The first of what is no number, and the worst of each quantity, at most three lines."""
    worst = {each.quantity: each for each in reversed(unlike) if math.isfinite(each.size)}
    shown = [each for each in unlike if math.isinf(each.size)][:2]
    shown += sorted(worst.values(), key=lambda each: -each.size)[: 3 - len(shown)]
    rest = len(unlike) - len(shown)
    return "\n    ".join([*map(str, shown), *([f"and {rest} more"] if rest else [])])


def main(arguments: Sequence[str]) -> int:
    """Exit code: 0 where nothing differs beyond its tolerance."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", action="store_true", help="write the records anew")
    parser.add_argument("parts", nargs="*", help="only records whose names hold one of these")
    asked = parser.parse_args(arguments)

    def wanted(name: str) -> bool:
        return not asked.parts or any(part in name for part in asked.parts)

    recorded, flown = _read(), [name for name in names() if wanted(name)]
    if not flown:
        parser.error(f"no record's name holds {' or '.join(asked.parts)}; one is {names()[0]}")
    records = parallel_map(record, [(name,) for name in flown], WORKERS, "golden")
    found = dict(zip(flown, records, strict=True))
    failed = [name for name, content in found.items() if RAISED in content]
    if asked.record and failed:
        print("\n".join(f"{name}: {found[name][RAISED]}" for name in failed))
        return 1
    if asked.record:
        kept = recorded if asked.parts else {}
        _write({**kept, **found, "versions": _versions()})
        print(f"{len(found)} records written to {FOLDER}")
        return 0
    before, now = recorded.pop("versions", {}), _versions()
    for name in [name for name in now if before.get(name) != now[name]]:
        print(f"recorded with {name} {before.get(name)}, now {now[name]}")
    recorded = {name: content for name, content in recorded.items() if wanted(name)}
    lines = list(_report(recorded, found))
    for line, _ in lines:
        print(line)
    others = sum(other for _, other in lines)
    print(
        f"{len(recorded)} records: {len(recorded) - len(lines)} bit for bit, "
        f"{len(lines) - others} within tolerance, {others} DIFFER"
    )
    return 1 if others else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
