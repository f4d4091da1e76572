from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture
def until() -> Callable[[Callable[[], Any]], None]:
    """Return a function that waits until a condition is true of which nobody tells."""

    def wait(condition: Callable[[], Any]) -> None:
        end = time.monotonic() + 20.0
        while not condition():
            assert time.monotonic() < end, "it never came true"
            time.sleep(0.002)

    return wait
