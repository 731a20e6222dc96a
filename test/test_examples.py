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

"""Every example runs, and shows what it says it shows."""

import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sources import ROOT, loaded

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.report import mission_report
from uav_tracking_mpc.report.metrics import metrics
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies import executors

EXAMPLES = ROOT / "examples"
ON_ORBIT = (
    "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]",
    "uav_simulator.initial_heading=1.5707963267948966",
)


def run(name, *arguments):
    finished = subprocess.run(
        [sys.executable, EXAMPLES / name, *map(str, arguments)], capture_output=True, text=True
    )
    assert finished.returncode == 0, finished.stdout + finished.stderr
    return finished.stdout


@pytest.fixture
def run_here(monkeypatch, capsys):
    """Runs an example in this process alone and without figures; what it prints."""
    monkeypatch.setattr(mission_report, "write_report", lambda log, *_: metrics(log))
    monkeypatch.setattr(executors.os, "sched_getaffinity", lambda _: {0})

    def run_here(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        code = 0
        try:
            runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        except SystemExit as ended:
            code = ended.code
        assert code == 0
        return capsys.readouterr().out

    return run_here


def test_every_example_has_a_test():
    tests = Path(__file__).read_text()
    files = {path.stem for path in ROOT.glob("test/**/test_*.py")}
    for example in EXAMPLES.glob("*.py"):
        assert f"test_{example.stem}" in files or example.stem in tests, example


def test_reproduce_the_paper(tmp_path, run_here):
    printed = run_here("reproduce_the_paper.py", tmp_path)
    (settled,) = re.findall(r"settled: range ([\d.]+) s", printed)
    assert float(settled) == pytest.approx(20.0, abs=1.0)
    assert f"Figures 2 and 3: {tmp_path / 'trajectory.png'}" in printed
    assert "(41)" in printed


def test_fly_your_own_plant():
    distances = loaded(EXAMPLES / "fly_your_own_plant.py").fly()
    assert abs(distances[0] - 608.0) < 2.0
    assert np.abs(distances[-200:] - 300.0).max() < 1.0


def test_add_a_law(run_here):
    printed = run_here("add_a_law.py", "--json", "--set", "mission.duration=40.0")
    (laws,) = json.loads(printed)["scenarios"].values()
    assert list(laws) == ["l1", "pure_pursuit"]
    assert laws["pure_pursuit"]["range_rms_m"] < 10.0


def test_add_a_limit(run_here):
    printed = run_here("add_a_limit.py")
    without, with_it = (float(x) for x in re.findall(r": +([\d.]+) m from", printed))
    assert without < 40.0
    assert with_it > 58.0


def test_add_a_model(tmp_path, run_here):
    """On the orbit, by the solver that need not be compiled."""
    settings = ["mission.duration=6.0", "nmpc_controller.solver=ipopt", *ON_ORBIT]
    words = [word for each in settings for word in ("--set", each)]
    flown = json.loads(run_here("add_a_model.py", "--json", "--output", tmp_path, *words))
    assert flown["steady_state"]["range_rms_m"] < 1.0


def test_add_a_plant(tmp_path, run_here):
    shorter = ["--set", "mission.duration=40.0"]
    flown = json.loads(run_here("add_a_plant.py", "--json", "--output", tmp_path, *shorter))
    assert flown["steady_state"]["range_rms_m"] < 5.0
    slipping = loaded(EXAMPLES / "add_a_plant.py").Slipping(SimulatorParameters(initial_speed=20.0))
    slipping.accept(np.tile([0.3, 0.0, 0.0], (6, 1)), np.arange(6.0))
    for _ in range(100):
        slipping.advance(0.05)
    assert slipping.sideslip == pytest.approx(0.25 * 0.3, rel=1e-3)
    course = np.arctan2(*slipping.truth.ground_velocity[1::-1])
    assert wrap_angle(course - slipping.truth.heading) == pytest.approx(0.25 * 0.3, rel=1e-3)


def test_fly_over_a_link():
    (error,) = re.findall(r"(-?[\d.]+) m from the orbit", run("fly_over_a_link.py"))
    assert abs(float(error)) < 1.0


def test_add_a_fault():
    """It is injected into a flight in test/cli/test_torture.py."""
    pytest.importorskip("rclpy")
    from filled_messages import filled_air
    from rclpy.serialization import deserialize_message, serialize_message

    from uav_tracking_mpc.nodes.topics import AIR_VELOCITY

    fault = loaded(EXAMPLES / "add_a_fault.py").IcedPitot()
    for stamp, airspeed in ((1, 20.0), (2, 25.0)):
        data = serialize_message(filled_air(stamp, airspeed))
        ((delay, delivered),) = fault.deliver(AIR_VELOCITY, data)
        message = deserialize_message(delivered, AIR_VELOCITY.type)
        assert (delay, message.header.stamp.nanosec) == (0.0, stamp)
        assert message.twist.linear.x == 20.0


def test_read_a_bag(tmp_path):
    pytest.importorskip("rclpy")
    from filled_messages import filled_odometry, filled_point, write_messages

    from uav_tracking_mpc.nodes.topics import ODOMETRY, TARGET

    log = simulate(load_configuration("paper", ["mission.duration=30.0"]))
    stamps = np.round(1e9 * log.time).astype(int).tolist()
    messages = [
        message
        for time, vehicle, target in zip(stamps, log.vehicle, log.target, strict=True)
        for message in (
            (TARGET, time, filled_point(time, target)),
            (ODOMETRY, time, filled_odometry(time, vehicle)),
        )
    ]
    printed = run("read_a_bag.py", write_messages(tmp_path / "mission.mcap", messages))
    (settled,) = re.findall(r"after ([\d.]+) s", printed)
    assert 15.0 < float(settled) < 25.0
