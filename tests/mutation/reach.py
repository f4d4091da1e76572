"""A plugin of pytest for a run under coverage: it records which test reached which line."""

from __future__ import annotations

from collections.abc import Iterator

import coverage
import pytest


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Name the test for all that is executed until the next one, its fixtures and threads included."""
    running = coverage.Coverage.current()
    assert running is not None, "run it with `python -m coverage run -m pytest -p reach`"
    running.switch_context(item.nodeid)
    yield
    running.switch_context("")
