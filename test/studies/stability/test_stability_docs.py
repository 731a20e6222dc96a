"""The page on stability: its pictures exist and are small."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_pictures_of_the_page_exist_and_are_small():
    names = re.findall(r"!\[.*?\]\((.*?)\)", (DOCS / "stability.md").read_text())
    assert len(names) >= 3
    for name in names:
        assert 0 < (DOCS / name).stat().st_size < 300_000
