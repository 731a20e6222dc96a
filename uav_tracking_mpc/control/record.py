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

"""What a controller was given and what it answered, as a file that can be flown again.

The file holds JSON lines: a header with version and parameters, then one line a call, in order,
with the clock at the call, what the stopwatch showed and, of a step, which solver was ready and the
command. Numbers are written so that they come back bit for bit. A controller that is given the same
calls answers the same commands on the same machine, as long as no solve runs out of time: that is
up to the clock.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import functools
import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc import __version__
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.estimation.measurement import Axis, Measurement, MeasurementError, SensorNoise
from uav_tracking_mpc.formulation.formulation import Formulation, solver_as_told
from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping
from uav_tracking_mpc.settings.tracking import TrackingParameters

PENDING = 200  # calls after which they are written, if nobody has asked for it before


class RecordingController(Controller):
    """A controller that writes down what it is given; see :class:`Controller`.

    Calls are kept in memory until :meth:`flush`, so that no answer waits for the disk.

    Args:
        parameters: What to fly and how.
        path: File to write, with its folder; an existing one is replaced.
        formulation: Of these parameters; made from them by default.
        stopwatch: Clock in [s] with which the controller measures how long it takes.

    Raises:
        ParameterError: The parameters cannot be flown, or the file cannot be written.
    """

    def __init__(
        self,
        parameters: TrackingParameters,
        path: Path,
        formulation: Formulation | None = None,
        stopwatch: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._readings: list[float] = []

        def read() -> float:
            self._readings.append(stopwatch())
            return self._readings[-1]

        self._calls: list[dict[str, Any]] = []
        super().__init__(parameters, formulation, read)
        header = {"version": __version__, "parameters": dataclasses.asdict(parameters)}
        if self.formulation is not None:
            header["solver"] = self.formulation.solver.name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("w", encoding="utf-8")
            self._write([header])
        except OSError as error:
            raise ParameterError(
                f"parameter 'record' is {str(path)!r}, must be a file that can be written: {error}"
            ) from error
        self._calls = []  # those of the base while it is made are none

    def flush(self) -> None:
        """Write the calls that are kept in memory; where that fails the record ends."""
        calls, self._calls = self._calls, []
        if self._file.closed:
            return
        try:
            self._write(calls)
        except OSError as error:
            self.events.add(Level.WARNING, f"the record ends, the flight goes on: {error}")
            self._close()

    def close(self) -> None:
        """Write what is left and close the file."""
        self.flush()
        self._close()

    def _write(self, calls: Iterable[dict[str, Any]]) -> None:
        self._file.writelines(json.dumps(call, default=_plain) + "\n" for call in calls)
        self._file.flush()

    def _close(self) -> None:
        with contextlib.suppress(OSError):  # it writes once more what could not be written
            self._file.close()

    def _note(self, name: str, arguments: Sequence[Any], named: dict[str, Any]) -> dict[str, Any]:
        """Remember a call; what is returned will be written, and may be added to."""
        if len(self._calls) >= PENDING:
            self.flush()
        self._readings = []
        # As they are now: a caller may use an array again before it is written.
        call = copy.deepcopy({"call": name, "arguments": list(arguments), "named": named})
        self._calls.append({**call, "stopwatch": self._readings})
        return self._calls[-1]

    def step(self, measurement: Measurement, now: float) -> Command | None:
        """See :meth:`Controller.step`."""
        call = self._note("step", (measurement, now), {})
        command = super().step(measurement, now)
        if self.formulation is not None:
            call["solver"] = self.formulation.solver.name
        if command is not None:
            answer = {name: getattr(command, name) for name in RecordedCommand._fields}
            call["command"] = {**answer, "mode": command.mode.value}
        return command


def _noted(name: str) -> Callable[..., Any]:
    """A method of a controller, which remembers its arguments before it is called."""
    method = getattr(Controller, name)

    @functools.wraps(method)
    def noted(controller: RecordingController, *arguments: Any, **named: Any) -> Any:
        controller._note(name, arguments, named)
        return method(controller, *arguments, **named)

    return noted


for _name in ("reset", "change", "see_air", "see_target", "see_state", "engage", "fall_silent"):
    setattr(RecordingController, _name, _noted(_name))


class RecordedCommand(NamedTuple):
    """A command as it was answered.

    Attributes:
        inputs: (u_psi, u_chi, u_v) of each segment, shape (n, 3), in [rad/s, rad/s, m/s^2].
        step: Length of a segment in [s].
        mode: Where it came from, in words.
        out_of_time: Whether its solve met the time budget.
    """

    inputs: NDArray[np.float64]
    step: float
    mode: str
    out_of_time: bool


class ReplayedStep(NamedTuple):
    """One step of a record.

    Attributes:
        recorded: What was answered; None for nothing.
        command: What is answered now.
    """

    recorded: RecordedCommand | None
    command: Command | None

    @property
    def same(self) -> bool:
        """Whether both commands are the same bit for bit."""
        if self.recorded is None or self.command is None:
            return self.recorded is self.command
        return (
            np.array_equal(self.recorded.inputs, self.command.inputs)
            and self.recorded.step == self.command.step
            and self.recorded.mode == self.command.mode.value
        )


def replay(path: Path) -> Iterator[ReplayedStep]:
    """Fly a record again, step by step; solves may take their time.

    Args:
        path: File that a :class:`RecordingController` has written.

    Raises:
        ValueError: It is no such file.
    """
    with path.open(encoding="utf-8") as file:
        header = _header(path, file)
        readings: list[float] = []
        parameters = from_mapping(TrackingParameters, header["parameters"])
        solver = header.get("solver")
        told = solver_as_told(lambda: solver in (None, parameters.solver))
        formulation = formulation_of(parameters, told)
        controller = Controller(
            parameters, formulation, lambda: readings.pop(0) if readings else math.nan
        )
        for line in file:
            try:
                call = json.loads(line)
            except ValueError:
                if line.endswith("\n"):
                    raise
                return  # torn off as the process or its disk ended
            solver = call.pop("solver", solver)
            readings[:] = call.pop("stopwatch", ())
            recorded = call.pop("command", None)
            if recorded is not None:
                recorded = RecordedCommand(np.array(recorded.pop("inputs")), **recorded)
            if controller.formulation is not None:
                controller.formulation.solver.time_limit = math.inf
            command = _repeat(controller, **call)
            if call["call"] == "step":
                yield ReplayedStep(recorded, command)


def recorded_parameters(path: Path) -> TrackingParameters:
    """Parameters with which the controller of a record began.

    Args:
        path: File that a :class:`RecordingController` has written.

    Raises:
        ValueError: It is no such file, or its parameters are not allowed here.
        OSError: It cannot be read.
    """
    with path.open(encoding="utf-8") as file:
        return from_mapping(TrackingParameters, _header(path, file)["parameters"])


def _header(path: Path, file: Iterator[str]) -> dict[str, Any]:
    header = json.loads(next(file, "{}"))
    if not (isinstance(header, dict) and "parameters" in header):
        raise ValueError(f"{path} is not the record of a controller")
    return header


def _repeat(
    controller: Controller, call: str, arguments: list[Any], named: dict[str, Any]
) -> Command | None:
    """Make a call again; one that was refused is refused again."""
    if call in ("step", "see_state"):
        arguments[0] = _measurement(arguments[0])
    try:
        answer = getattr(controller, call)(*arguments, **named)
    except (MeasurementError, ParameterError):
        return None
    return answer if call == "step" else None


def _measurement(values: dict[str, Any]) -> Measurement:
    """A measurement of this record or of an older one.

    In records of 0.2 the noise may be unknown, and one number holds for all axes of a vector; those
    without an axis are of the air velocity.
    """
    noise = dict(values["noise"] or {})
    if "attitude" in noise:
        noise["heading"] = noise["path_angle"] = noise.pop("attitude")
    for name in {"position", "velocity"} & set(noise):
        noise[name] = tuple(np.broadcast_to(noise[name], 3).tolist())
    axis = Axis(values.get("axis", Axis.AIR_VELOCITY))
    return Measurement(**{**values, "noise": SensorNoise(**noise), "axis": axis})


def _plain(value: Any) -> Any:
    """What JSON does not know."""
    if isinstance(value, Axis):
        return value.value
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Measurement):
        return dataclasses.asdict(value)
    return repr(value)  # nothing that is taken: it was refused, and will be
