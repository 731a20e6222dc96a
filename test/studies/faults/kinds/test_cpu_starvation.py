import os

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.cpu_starvation import PER_CORE, CpuStarvation


def test_busy_processes_are_ended():
    fault = CpuStarvation()
    fault.begin(None, 1.0, 0)
    busy = fault._busy
    assert len(busy) == PER_CORE * os.cpu_count()
    assert all(process.poll() is None for process in busy)
    fault.end(None)
    assert all(process.poll() is not None for process in busy)
