import copy
import math
import pickle
from types import SimpleNamespace as Message

import pytest

from uav_tracking_mpc.studies.faults.fault_kinds import (
    AIR,
    CLOCK,
    COMMAND,
    KINDS,
    ODOMETRY,
    RELAY,
    STREAMS,
    TARGET,
)
from uav_tracking_mpc.studies.faults.message_faults import JITTER, MessageFault


def stamp(sec):
    return Message(sec=sec, nanosec=0)


def vector(x=0.0, y=0.0, z=0.0):
    return Message(x=x, y=y, z=z)


def message(topic, sec=100):
    """A message with the fields of the topic's type, without ROS."""
    if topic == CLOCK:
        return Message(clock=stamp(sec))
    header = Message(stamp=stamp(sec), frame_id="map")
    if topic == TARGET:
        return Message(header=header, point=vector(1.0, 2.0, 0.0))
    if topic == AIR:
        return Message(header=header, twist=Message(linear=vector(4.0), angular=vector()))
    if topic == COMMAND:
        point = Message(
            velocities=[Message(angular=vector())], accelerations=[Message(linear=vector())]
        )
        return Message(header=header, points=[point, copy.deepcopy(point)])
    orientation = Message(x=0.0, y=0.0, z=0.0, w=1.0)
    return Message(
        header=header,
        child_frame_id="base_link",
        pose=Message(pose=Message(position=vector(100.0, 0.0, 50.0), orientation=orientation)),
        twist=Message(twist=Message(linear=vector(4.0), angular=vector())),
    )


def fault(kind, seed=0):
    return MessageFault(kind, seed, 150.0, lambda topic, data: pickle.loads(data), pickle.dumps)


def arrivals(kind, topic, count=200, seed=0):
    """(delay, message) of everything that arrives."""
    struck = fault(kind, seed)
    return [
        (delay, pickle.loads(data))
        for sec in range(100, 100 + count)
        for delay, data in struck.deliver(topic, pickle.dumps(message(topic, sec)))
    ]


RELAYED = [kind for kind in KINDS.values() if kind.action == RELAY]


@pytest.mark.parametrize("kind", RELAYED, ids=lambda kind: kind.name)
def test_a_fault_strikes_its_own_topics_and_no_other(kind):
    for topic in STREAMS:
        sent = [(0.0, message(topic, sec)) for sec in range(100, 300)]
        assert (arrivals(kind.name, topic) != sent) == (topic in kind.streams)


@pytest.mark.parametrize("kind", RELAYED, ids=lambda kind: kind.name)
def test_a_seed_is_a_fault(kind):
    # As text: nan is not itself.
    assert repr(arrivals(kind.name, kind.streams[0])) == repr(arrivals(kind.name, kind.streams[0]))


def test_one_message_in_five_is_lost():
    assert 0.7 < len(arrivals("loss", ODOMETRY, 1000)) / 1000 < 0.9


def test_jitter_is_bounded():
    delays = [delay for delay, _ in arrivals("jitter", ODOMETRY)]
    assert 0.0 <= min(delays) < max(delays) <= JITTER == 0.2


@pytest.mark.parametrize("topic", [ODOMETRY, AIR])
def test_a_gap_leaves_nothing(topic):
    assert arrivals("gap_state", topic) == []


def test_some_messages_stay_good_among_bad_ones():
    values = [m.point for _, m in arrivals("target_nan", TARGET)]
    bad = [math.isnan(p.x) or math.isnan(p.y) or math.isnan(p.z) for p in values]
    assert 0.3 < sum(bad) / len(bad) < 0.7


def test_duplicates_and_disorder():
    assert len(arrivals("odometry_duplicated", ODOMETRY)) == 600
    delays = {delay for delay, _ in arrivals("odometry_reordered", ODOMETRY)}
    assert delays == {0.0, 0.3}


def test_a_target_leaps_to_one_place_and_stays_there():
    places = {(m.point.x, m.point.y) for _, m in arrivals("target_teleport", TARGET)}
    ((x, y),) = places
    assert math.hypot(x - 1.0, y - 2.0) == pytest.approx(150.0)


def test_the_clock_jumps_by_one_offset_and_never_below_zero():
    for kind, sign in (("clock_forward", 1), ("clock_backward", -1)):
        for seed in range(10):
            seconds = [m.clock.sec for _, m in arrivals(kind, CLOCK, seed=seed)]
            assert min(seconds) >= 0
            if min(seconds) > 0:
                assert len({sec - true for true, sec in enumerate(seconds, 100)}) == 1
            assert sign * (seconds[-1] - 299) > 0
