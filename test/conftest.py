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

"""What several tests share: the paper's numbers, and a domain of their own for nodes."""

from __future__ import annotations

import os

import numpy as np
import pytest

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.orbit import Orbit

os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")


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
