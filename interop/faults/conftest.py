"""Fixtures of the tests of faults: two hosts with a cable between them whose faults the test chooses."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
pytest.register_assert_rewrite("site_of_two")

from site_of_two import Site  # noqa: E402  found through the path set above


@pytest.fixture
def site() -> Iterator[Site]:
    """A robot and a laptop, for one test."""
    with Site() as made:
        yield made
