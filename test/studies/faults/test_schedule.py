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


from itertools import islice
from types import SimpleNamespace

import pytest

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.studies.faults.schedule import (
    RESTARTING_FAULTS,
    catalogue,
    schedule,
    variants,
)

pytest.importorskip("rclpy")


OF_TOPIC = ("nan", "inf", "huge", "frame", "old_stamp", "future_stamp", "duplicated", "reordered")
EXPECTED = {
    *(f"{action}_{node}" for action in ("kill", "stop") for node in NODES),
    *(
        f"{topic}_{word}"
        for topic in ("odometry", "target", "command", "air_velocity")
        for word in OF_TOPIC
    ),
    *(f"odometry_{word}" for word in ("quaternion", "negative_speed", "absurd")),
    *("target_absurd", "command_absurd", "command_empty", "air_velocity_negative_speed"),
    *("cpu_starvation", "loss", "jitter", "gap_state", "gap_target", "gap_command"),
    *("target_teleport", "target_lost", "clock_forward", "clock_backward", "clock_pause"),
    *("parameter_storm", "solver_budget"),
}
STUCK = """
from uav_tracking_mpc.nodes.topics import TARGET
from uav_tracking_mpc.studies.faults.stream_fault import StreamFault

class Stuck(StreamFault):
    name = {name!r}
    family = "target"
    duration = (1.0, 3.0)
    streams = (TARGET,)

    def deliver(self, topic, data):
        return []
"""


def stuck(folder, name):
    """A reference to a fault of an outside file."""
    file = folder / "stuck.py"
    file.write_text(STUCK.format(name=name))
    return f"{file}:Stuck"


def test_every_fault_has_a_label_and_each_object_is_its_own():
    faults = catalogue()
    assert set(faults) == EXPECTED
    assert len(EXPECTED) == 58
    assert all(label == fault.label for label, fault in faults.items())
    assert catalogue()["loss"] is not faults["loss"]
    families = [fault.family for fault in faults.values()]
    assert sorted(families) == families


def test_a_fault_of_an_outside_file_is_found_by_its_reference(tmp_path):
    fault = catalogue([stuck(tmp_path, "stuck_target")])["stuck_target"]
    assert list(variants(fault.reference)) == ["stuck_target"]


def test_two_faults_of_one_label_and_what_is_no_fault_are_told(tmp_path):
    with pytest.raises(ExtensionError, match="'target_lost' of fault 'silence'"):
        catalogue([stuck(tmp_path, "target_lost")])
    with pytest.raises(ExtensionError, match=r"fault is 'banana', must be one of clock_jump, "):
        variants("banana")


def fault(label, victim="", restarts=False):
    return SimpleNamespace(
        label=label, victim=victim, restarts=restarts, duration=(0.5 if victim else 1.0, 3.0)
    )


FAULTS = {
    fault.label: fault
    for fault in (
        *(fault(f"message_{number}") for number in range(50)),
        *(fault(f"kill_{node}", node, restarts=True) for node in "abc"),
        *(fault(f"stop_{node}", node) for node in "abc"),
    )
}


def first(count, seed=0, minutes=10.0, **options):
    return list(islice(schedule(FAULTS, seed, minutes, **options), count))


def test_a_seed_is_a_schedule_of_which_a_case_can_be_run_alone():
    assert first(300, seed=7) == first(300, seed=7) != first(300, seed=8)
    (alone,) = islice(schedule(FAULTS, 7, 10.0), 123, 124)
    assert alone == first(124, seed=7)[-1]


def test_every_fault_comes_before_any_comes_twice():
    seen = [kind for case in first(100) for kind in case.kinds]
    assert set(seen[: len(FAULTS)]) == set(FAULTS)


def test_what_is_asked_for_comes_first():
    assert first(1, first=["message_31"])[0].kinds[0] == "message_31"
    seen = [kind for case in first(100, first=["message_31"]) for kind in case.kinds]
    assert "message_31" not in seen[1 : len(FAULTS)]


def test_a_process_has_one_fault_at_a_time_and_each_lasts_as_it_says():
    for case in first(500):
        assert sum(bool(FAULTS[kind].victim) for kind in case.kinds) <= 1
        assert len(set(case.kinds)) == len(case.kinds) > 0
        for scheduled in case.faults:
            shortest, longest = FAULTS[scheduled.label].duration
            assert shortest <= scheduled.duration <= longest


def test_nodes_are_restarted_early_alone():
    seen = [kind for case in first(1000, minutes=10.0) for kind in case.kinds]
    restarts = [index for index, kind in enumerate(seen) if FAULTS[kind].restarts]
    assert restarts[0] < 20
    assert restarts[-1] < RESTARTING_FAULTS * 10 + len(FAULTS)
