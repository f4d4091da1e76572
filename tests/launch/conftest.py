"""What the tests of launching share."""

from __future__ import annotations

import subprocess
from typing import Any

import pytest


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """All processes that this one has started, in order: their pipes are how the parts of a launch are connected."""
    processes: list[Any] = []

    class Noted(subprocess.Popen):  # type: ignore[type-arg]  # bytes or text
        def __init__(self, *words: Any, **options: Any) -> None:
            super().__init__(*words, **options)
            processes.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)
    return processes
