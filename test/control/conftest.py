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

"""A controller whose plans can be made to fail, and where it starts."""

import pytest
from controller_cases import PAPER, Faulty, estimate, paper_situation

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation


@pytest.fixture(scope="module")
def paper_formulation():
    return PaperFormulation(PAPER)


@pytest.fixture
def controller(paper_formulation):
    paper_formulation.reset()
    return Controller(PAPER, Faulty(paper_formulation))


@pytest.fixture
def start(paper_start):
    return estimate(paper_situation(paper_start))
