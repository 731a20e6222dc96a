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

"""A record comes back as it was written, and is flown again to the same commands."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.control.record import RecordingController, replay
from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError, SensorNoise
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.formulation.formulation import solver_as_told
from uav_tracking_mpc.parameters.specification import ParameterError

FLIGHT = small_uav.parameters()
TICK = 0.05


class Flown:
    """A flight that is everything but smooth, for a controller that is given.

    A circle flown clockwise in wind, at 20 Hz; the target runs, and is seen at 10 Hz.
    """

    def __init__(self, controller, seed=0):
        self.controller, self.rng = controller, np.random.default_rng(seed)
        self.time, self.commands = 100.0, []

    def fly(self, ticks, target=True, air=True, away=0.0):
        for _ in range(ticks):
            self.time += TICK
            angle = -0.08 * self.time
            position = np.array([275.0 * np.cos(angle) + away, 275.0 * np.sin(angle), 120.0])
            position += self.rng.normal(0.0, 0.3, 3)
            heading = np.remainder(angle + 0.5 * np.pi, 2.0 * np.pi) - np.pi
            velocity = 22.0 * np.array([np.cos(heading), np.sin(heading), 0.0]) + [3.0, 1.0, 0.0]
            if air:
                self.controller.see_air(self.time, 22.0 + self.rng.normal(0.0, 0.1))
            if target and self.rng.random() < 0.5:
                self.controller.see_target(self.time, self.rng.normal(0.0, 1.0, 3))
            measurement = Measurement(self.time, position, velocity, heading, 0.01, -0.08)
            command = self.controller.step(measurement, self.time + self.rng.uniform(0.0, 0.01))
            self.commands.append(command)


def eventful(controller):
    """Everything that can happen to a controller; the commands that it answered."""
    flown = Flown(controller)
    flown.fly(10, target=False)
    flown.fly(20)
    controller.see_target(flown.time + 0.01, [3.0, 1.0, 0.0], [2.0, 0.0, 0.0], np.eye(6))
    controller.change(range=340.0, bank_max=0.7, solve_time_max=4.0)
    flown.fly(20, air=False)
    flown.time += 2.0  # states get lost while the clock goes on
    controller.see_target(flown.time, [3.0, 1.0, 0.0], now=flown.time)
    flown.fly(10)
    with pytest.raises(ParameterError):
        controller.change(range=1.0)
    with pytest.raises(MeasurementError):
        controller.see_target(flown.time, [np.nan, 0.0, 0.0])
    flown.fly(1, away=5e3)
    flown.fly(10, target=False)
    controller.change(target_timeout=0.2)
    flown.fly(10, target=False)
    controller.engage(False)
    flown.fly(10)
    controller.engage(True)
    flown.fly(10)
    controller.fall_silent("vehicle state is lost")
    quiet = Measurement(
        flown.time + TICK, np.zeros(3), np.ones(3), 0.0, 0.0,
        noise=SensorNoise(position=(100.0,) * 3),
    )  # fmt: skip
    controller.see_state(quiet)
    flown.time = 3.0
    flown.fly(20)
    controller.reset()
    flown.time = 50.0
    flown.fly(10)
    return flown.commands


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    path = tmp_path_factory.mktemp("record") / "folder" / "controller.jsonl"
    controller = RecordingController(FLIGHT, path)
    commands = eventful(controller)
    controller.close()
    return path, commands


def test_a_record_is_flown_again_bit_for_bit(flight):
    path, commands = flight
    steps = list(replay(path))
    assert len(steps) == len(commands)
    for command, step in zip(commands, steps, strict=True):
        assert step.same
        if command is not None:
            np.testing.assert_array_equal(step.recorded.inputs, command.inputs)
            assert step.command.orbit == command.orbit
    modes = {command.mode for command in commands if command is not None}
    assert modes >= {FallbackMode.OPTIMAL, FallbackMode.LOITER, FallbackMode.HOLD}
    assert commands.count(None) > 10


def test_a_flight_that_began_on_another_solver_is_flown_again_bit_for_bit(tmp_path):
    compiled = []  # nothing, until the machine code is there
    unhurried = replace(FLIGHT, solve_time_max=10.0)  # whatever else the machine does
    formulation = formulation_of(unhurried, solver_as_told(lambda: bool(compiled)))
    path = tmp_path / "controller.jsonl"
    controller = RecordingController(unhurried, path, formulation, stopwatch=lambda: 0.0)
    flown = Flown(controller)
    flown.fly(8)
    assert formulation.solver.name == "ipopt"
    assert flown.commands[-1].mode is FallbackMode.OPTIMAL
    compiled.append(True)
    flown.fly(8)
    assert formulation.solver.name == "newton"
    controller.close()
    steps = list(replay(path))
    assert len(steps) == len(flown.commands)
    assert all(step.same for step in steps)


def test_recording_changes_nothing(tmp_path):
    recording = RecordingController(FLIGHT, tmp_path / "record.jsonl", stopwatch=lambda: 0.0)
    recorded, plain = (
        eventful(controller) for controller in (recording, Controller(FLIGHT, None, lambda: 0.0))
    )
    for one, other in zip(recorded, plain, strict=True):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_array_equal(one.inputs, other.inputs)


def test_a_record_has_what_was_given_though_an_array_is_filled_anew(tmp_path):
    path, position = tmp_path / "controller.jsonl", np.zeros(3)
    controller = RecordingController(FLIGHT, path)
    for east in (1.0, 2.0):
        position[0] = east
        controller.see_target(100.0 + east, position)
    controller.close()
    calls = [json.loads(line) for line in path.read_text().splitlines()[1:]]
    assert [call["arguments"][1] for call in calls] == [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]


def test_a_difference_is_seen(flight, tmp_path):
    path, _ = flight
    lines = path.read_text().splitlines()
    index = next(i for i, line in enumerate(lines) if '"command"' in line)
    call = json.loads(lines[index])
    call["command"]["inputs"][3][1] = np.nextafter(call["command"]["inputs"][3][1], 1.0)
    lines[index] = json.dumps(call)
    changed = tmp_path / "changed.jsonl"
    changed.write_text("\n".join(lines))
    assert [step.same for step in replay(changed)].count(False) == 1


def test_a_solve_that_met_its_budget_is_marked(tmp_path):
    path = tmp_path / "controller.jsonl"
    controller = RecordingController(replace(FLIGHT, solve_time_max=1e-4), path)
    flown = Flown(controller)
    flown.fly(10)
    controller.close()
    recorded = [step.recorded for step in replay(path) if step.recorded is not None]
    assert recorded[0].out_of_time
    assert [r.out_of_time for r in recorded] == [
        command.out_of_time for command in flown.commands if command is not None
    ]


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ParameterError, match="'record' is .*, must be a file that can be written"):
        RecordingController(replace(FLIGHT, law="l1"), tmp_path / "file" / "record.jsonl")


def test_what_was_refused_does_not_keep_the_rest_from_being_written(tmp_path):
    path = tmp_path / "record.jsonl"
    controller = RecordingController(replace(FLIGHT, law="l1"), path)
    with pytest.raises(ParameterError):
        controller.change(range={300.0})
    flown = Flown(controller)
    flown.fly(20)
    controller.close()
    assert [step.same for step in replay(path)] == [True] * 20


def test_a_silence_of_the_controllers_own_is_no_call_of_somebody_else(tmp_path, monkeypatch):
    path = tmp_path / "record.jsonl"
    controller = RecordingController(replace(FLIGHT, law="l1"), path)
    flown = Flown(controller)
    flown.fly(5)
    monkeypatch.setattr(Navigator, "lost", True)
    flown.fly(1)
    assert flown.commands[-1] is None
    controller.close()
    assert controller.modes.mode is FallbackMode.SILENCE
    assert "fall_silent" not in path.read_text()


FULL = Path("/dev/full")  # a disk without room


def test_a_disk_that_is_full_at_the_start_is_named():
    with pytest.raises(ParameterError, match="'record' is '/dev/full', must be a file that can be"):
        RecordingController(replace(FLIGHT, law="l1"), FULL)


def test_a_flight_goes_on_where_its_record_cannot(tmp_path):
    path = tmp_path / "record.jsonl"
    controller = RecordingController(replace(FLIGHT, law="l1"), path)
    flown = Flown(controller)
    flown.fly(20)
    controller.flush()
    controller._file.close()
    controller._file = FULL.open("w")
    flown.fly(300)
    assert flown.commands[-1] is not None
    words = [event.words for event in controller.events.take()]
    assert sum("the record ends, the flight goes on" in each for each in words) == 1
    controller.close()
    assert len(list(replay(path))) == 20


def test_a_record_whose_last_line_is_torn_is_flown_up_to_there(flight, tmp_path):
    path, commands = flight
    torn = tmp_path / "torn.jsonl"
    torn.write_text(path.read_text()[:-30])
    steps = list(replay(torn))
    assert len(steps) == len(commands) - 1
    assert all(step.same for step in steps)


@pytest.mark.parametrize("noise", [None, {"position": 3.0, "velocity": 0.1, "attitude": 0.01}])
def test_a_record_of_0_2_is_flown_again(noise, tmp_path):
    """There the noise was unknown, or one number for all axes."""
    new, old = tmp_path / "new.jsonl", tmp_path / "old.jsonl"
    known = noise and SensorNoise((3.0,) * 3, (0.1,) * 3, 0.01, 0.01)
    recorder = RecordingController(FLIGHT, new)
    recorder.see_target(0.0, np.zeros(3))
    for stamp in (0.0, TICK):
        place = np.array([22.0 * stamp, 300.0, 120.0])
        velocity = np.array([22.0, 0.0, 0.0])
        measurement = Measurement(stamp, place, velocity, 0.0, 0.0, airspeed=22.0)
        recorder.step(replace(measurement, **({"noise": known} if known else {})), stamp)
    recorder.close()
    calls = [json.loads(line) for line in new.read_text().splitlines()]
    for call in calls:
        if call.get("call") == "step":
            call["arguments"][0]["noise"] = noise
    old.write_text("\n".join(map(json.dumps, calls)))
    steps = list(replay(old))
    assert len(steps) == 2
    assert all(step.same and step.command is not None for step in steps)


def test_what_is_no_record_is_refused(tmp_path):
    path = tmp_path / "no_record.jsonl"
    path.write_text("{}\n")
    with pytest.raises(ValueError, match="is not the record of a controller"):
        list(replay(path))


def test_the_noise_that_was_told_is_flown_again(tmp_path):
    """Commands depend on it, and the record keeps it."""
    path, commands = tmp_path / "told.jsonl", {}
    for name, told in {"told": 3.0, "untold": 0.0}.items():
        controller = RecordingController(FLIGHT, tmp_path / f"{name}.jsonl")
        random, flown = np.random.default_rng(1), []
        controller.see_target(0.0, np.zeros(3))
        for tick in range(20):
            position = np.array([22.0 * TICK * tick, 300.0, 120.0])
            measurement = Measurement(
                TICK * tick,
                position + 3.0 * random.standard_normal(3),
                np.array([22.0, 0.0, 0.0]),
                0.0,
                0.0,
                airspeed=22.0,
                noise=SensorNoise((told,) * 3, (0.1,) * 3, 0.01, 0.01),
            )
            flown.append(controller.step(measurement, TICK * tick))
        controller.close()
        commands[name] = [command.inputs[0] for command in flown if command is not None]
    assert all(step.same for step in replay(path))
    assert not np.array_equal(commands["told"], commands["untold"])
