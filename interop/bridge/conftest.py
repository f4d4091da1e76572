"""Fixtures of the tests of bridges: hosts with a master and a bridge each, and cables whose faults the test chooses."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
pytest.register_assert_rewrite("sites")

from sites import Sites  # noqa: E402  found through the path set above


@pytest.fixture
def sites() -> Iterator[Sites]:
    """Hosts for one test."""
    with Sites() as made:
        yield made
