"""A digest changes with what an object holds, however deep, and with nothing else."""

from collections import deque

import numpy as np
from fingerprint import fingerprint

from uav_tracking_mpc.estimation.command_history import CommandHistory
from uav_tracking_mpc.estimation.target_filter import TargetFilter


def test_values_arrays_and_objects_count():
    history = CommandHistory(1.0)
    filtered = TargetFilter(0.1, 0.5)
    before = fingerprint([history, filtered, 1])
    assert fingerprint([history, filtered, 1]) == before
    assert fingerprint([history, filtered, 2]) != before
    inputs = np.zeros((1, 3))
    history.add(0.0, 0.0, inputs, 1.0)
    added = fingerprint([history, filtered, 1])
    assert added != before
    inputs[0, 2] = 1e-300
    assert fingerprint([history, filtered, 1]) != added
    filtered.update(0.0, [1.0, 2.0, 3.0])
    assert fingerprint([filtered]) != fingerprint([TargetFilter(0.1, 0.5)])


def test_what_may_change_is_left_out():
    filtered = TargetFilter(0.1, 0.5)
    before = fingerprint([filtered], ["rejected"])
    filtered.rejected += 1
    assert fingerprint([filtered], ["rejected"]) == before


def test_numbers_that_look_alike_differ():
    things = [0.0, -0.0, 0, False, None, "0", float("nan"), [], (0,), deque([0, 0]), {0: 0}]
    assert len({fingerprint([thing]) for thing in things}) == len(things)
