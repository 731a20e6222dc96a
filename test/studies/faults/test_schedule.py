from itertools import islice

from uav_tracking_mpc.studies.faults.fault_kinds import KILL, KINDS, NODES, STOP
from uav_tracking_mpc.studies.faults.schedule import KILLING_FAULTS, schedule


def first(count, seed=0, minutes=10.0):
    return list(islice(schedule(seed, minutes), count))


def test_a_seed_is_a_schedule():
    assert first(300, seed=7) == first(300, seed=7)
    assert first(300, seed=7) != first(300, seed=8)


def test_a_case_can_be_run_alone():
    (alone,) = islice(schedule(7, 10.0), 123, 124)
    assert alone == first(124, seed=7)[-1]


def test_every_kind_comes_before_any_comes_twice():
    seen = [kind for case in first(100) for kind in case.kinds]
    assert len(KINDS) >= 50
    assert set(seen[: len(KINDS)]) == set(KINDS)


def test_every_node_is_killed_and_stopped_and_starved():
    for node in NODES:
        assert KINDS[f"kill_{node}"].action == KILL
        assert KINDS[f"stop_{node}"].action == STOP
        assert (KINDS[f"stop_{node}"].shortest, KINDS[f"stop_{node}"].longest) == (0.5, 3.0)


def test_a_process_is_struck_by_one_fault_at_a_time():
    for case in first(500):
        strokes = [kind for kind in case.kinds if KINDS[kind].action in (KILL, STOP)]
        assert len(strokes) <= 1
        assert len(set(case.kinds)) == len(case.kinds) > 0


def test_nodes_are_killed_early_alone():
    faults = [kind for case in first(1000, minutes=10.0) for kind in case.kinds]
    killing = [index for index, kind in enumerate(faults) if KINDS[kind].action == KILL]
    assert killing[0] < 20
    assert killing[-1] < KILLING_FAULTS * 10 + len(KINDS)


def test_durations_are_those_of_the_kind():
    for case in first(500):
        for fault in case.faults:
            kind = KINDS[fault.kind]
            assert kind.shortest <= fault.duration <= kind.longest
