"""The comparison of pages lets the last digit move and nothing else."""

import pytest
from pages import assert_same

TEXT = "| varrho | 3.1733 | -1.2e-05 | row 12 | L2 |"


@pytest.mark.parametrize(("old", "new"), [("3.1733", "3.1734"), ("-1.2e-05", "-1.1e-05")])
def test_the_last_digit_may_move(old, new):
    assert_same(TEXT.replace(old, new), TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [("3.1733", "3.1735"), ("-1.2e-05", "1.2e-05"), ("12", "13"), ("L2", "L3"), ("row", "line")],
)
def test_nothing_else_may(old, new):
    with pytest.raises(AssertionError):
        assert_same(TEXT.replace(old, new), TEXT)
