"""What the README and the documentation say is what the code does."""

import re
from pathlib import Path

import pytest

from uav_tracking_mpc.nodes.reference_tables import tables, with_tables

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def test_tables_are_those_of_the_code():
    text = (ROOT / "README.md").read_text()
    assert with_tables(text) == text, "run `make docs`"
    assert len(tables()["nmpc_controller"].splitlines()) > 20


def test_a_text_without_a_place_is_refused():
    with pytest.raises(ValueError, match="no place for the table 'topics'"):
        with_tables("")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
        if "://" not in link:
            assert (page.parent / link).exists(), link
