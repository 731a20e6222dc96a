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

import math
import os

import pytest

from uav_tracking_mpc.studies.executors import parallel_map


@pytest.mark.parametrize("workers", [1, 2])
def test_results_are_in_order_and_one_worker_stays_in_this_process(workers):
    """``/proc/self`` is a link to the process that looks at it."""
    pieces = [(n, k) for n in range(10) for k in range(3)]
    found = parallel_map(math.comb, pieces, workers, show=False)
    assert found == [math.comb(n, k) for n, k in pieces]
    assert parallel_map(math.comb, [], workers, show=False) == []
    processes = parallel_map(os.path.realpath, [("/proc/self",)] * 2, workers, show=False)
    assert (f"/proc/{os.getpid()}" in processes) is (workers == 1)


def test_what_a_piece_raises_reaches_the_caller():
    with pytest.raises(ValueError, match="nonnegative|not defined for negative"):
        parallel_map(math.factorial, [(3,), (-1,)], workers=2, show=False)


def interrupted_at_three(piece):
    if piece == 3:
        raise KeyboardInterrupt
    return piece


def test_what_was_done_before_an_interruption_is_kept_and_the_bar_goes_to_stderr(capsys):
    numbers = [(k,) for k in range(6)]
    assert parallel_map(interrupted_at_three, numbers, 1, "numbers", least=3) == [0, 1, 2]
    with pytest.raises(KeyboardInterrupt):
        parallel_map(interrupted_at_three, numbers, 1, show=False, least=4)
    found = capsys.readouterr()
    assert found.out == ""
    assert "numbers" in found.err
