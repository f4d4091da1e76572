"""Generated code for definitions of every shape: the types vary here, where other tests vary values."""

from __future__ import annotations

import pytest
from definition_checks import faults

EACH = 250


@pytest.mark.parametrize("first", range(0, 2000, EACH))
def test_random_definitions(first: int) -> None:
    assert faults(range(first, first + EACH)) == []
