"""Generated code for definitions of every shape: the types vary here, where other tests vary values.

Feature: bytes and MD5 sums equal those of the rosbags library -- also on random input; truncated and corrupted
    messages are rejected, surplus bytes ignored
"""

from __future__ import annotations

import sys

import pytest
from definition_checks import faults

pytestmark = pytest.mark.once

EACH = 125
COUNT = 500
BEGIN = COUNT * (sys.version_info.minor % 4)
"""Each Python takes other ones: four of them see 2,000, as many as the comparison with genpy in interop."""


@pytest.mark.slow
@pytest.mark.parametrize("first", range(BEGIN, BEGIN + COUNT, EACH))
def test_random_definitions(first: int) -> None:
    assert faults(range(first, first + EACH)) == []
