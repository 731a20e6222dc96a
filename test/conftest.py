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

"""What all tests share: ROS domains for each worker, profiles of Hypothesis, the paper's numbers.

``quick`` is the profile of ``make test``: few examples, the same ones every time, so that the
verdict on a change does not depend on chance. ``full`` (``--hypothesis-profile=full``, in ``make
test-long``) searches anew each time. No test has a deadline.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from contextlib import ExitStack

import numpy as np
import pytest
from extras import missing_extra
from hypothesis import HealthCheck, settings

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.launch.supervisor import own_domain
from uav_tracking_mpc.nodes.ros.ros_environment import stay_on_this_machine

# One domain for nodes in this process and one for its children: who was killed is remembered for
# 20 s, and on one machine Fast DDS finds only so many participants, which this process uses up.
# Claimed as launchers claim theirs, so that nobody else comes; free when the process ends.
_claims = ExitStack()
os.environ["ROS_DOMAIN_ID"] = str(_claims.enter_context(own_domain(None)))
os.environ["DOMAIN_OF_PROCESSES"] = str(_claims.enter_context(own_domain(None)))
os.environ.pop("ROS_AUTOMATIC_DISCOVERY_RANGE", None)
stay_on_this_machine()
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"

# A shell that runs this in the background has it ignored, and children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile(
    "quick",
    max_examples=25,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("full", max_examples=200, deadline=None, print_blob=True)
settings.load_profile("quick")


@pytest.fixture(scope="module", autouse=True)
def nodes_of_this_file_are_gone(request):
    """A context that is shut down keeps its participant and threads until it is collected.

    Fast DDS finds only so many participants on one machine, so those of former files would hide
    those of later ones. A node that runs freezes what the collector knows, which is undone here.
    """
    yield
    if "rclpy" not in sys.modules:
        return
    gc.unfreeze()
    here = (item for item in request.session.items if item.path == request.path)
    if any(item.get_closest_marker("nodes") for item in here):
        gc.collect()


@pytest.fixture(scope="session")
def orbit() -> Orbit:
    """Table 1: r_d = 150 m, z_d = 50 m, v_d = 4 m/s, theta_d = pi/2."""
    return paper_numbers.ORBIT


@pytest.fixture(scope="session")
def weights() -> tuple[np.ndarray, np.ndarray]:
    """Q and R of (59)."""
    return np.diag(paper_numbers.STATE_WEIGHTS), np.diag(paper_numbers.INPUT_WEIGHTS)


@pytest.fixture(scope="session")
def paper_start() -> np.ndarray:
    """x_o of Section 6: (r, theta, z, chi, v)."""
    return np.array(paper_numbers.INITIAL_STATE)


class OptionalModule(pytest.Module):
    """A file of tests, skipped with a word where an extra that it imports is not installed."""

    def collect(self):
        try:
            return super().collect()
        except Exception as error:
            if (name := missing_extra(error)) is None:
                raise
            pytest.skip(f"{name} is not installed", allow_module_level=True)


def pytest_pycollect_makemodule(module_path, parent):
    """Every file may need an extra: `colcon test` runs with what package.xml declares."""
    return OptionalModule.from_parent(parent, path=module_path)


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(crashitem):
    """Name at once what has ended its worker: a run that is cut short has no summary."""
    print(f"\n{crashitem} has ended its worker", flush=True)
