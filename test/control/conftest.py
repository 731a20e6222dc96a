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
