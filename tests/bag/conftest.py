"""Bags to test with."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1

from .made import write_bag

Make = Callable[..., Path]
DEADLINE = 20.0


@pytest.fixture
def make_bag(tmp_path: Path) -> Make:
    """Makes a bag with numbers on /a and texts on /b: message i is at 100 s + i * 10 ms, and holds i."""

    def make(
        name: str = "x.bag",
        count: int = 100,
        compression: str = "none",
        chunk_threshold: int = 1000,
        close: bool = True,
    ) -> Path:
        return write_bag(tmp_path / name, count, compression, chunk_threshold, close)

    return make


def values(path: Path, *, unindexed: bool = True) -> list[int]:
    """What the messages of such a bag hold, in the order in which they are read."""
    import pyros1.bag

    with pyros1.bag.open(path, unindexed=unindexed) as bag:
        return [int(item.message.data) for item in bag.messages()]


@pytest.fixture
def start(environ: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts a pyros1 command, or with ``program`` another Python program; what is left of it is killed."""
    children: list[subprocess.Popen[str]] = []

    def run(*words: str, program: Path | None = None, **settings: Any) -> subprocess.Popen[str]:
        source = str(Path(pyros1.__file__).parents[1])
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **settings}
        child = subprocess.Popen(
            [sys.executable, *(["-m", "pyros1"] if program is None else [str(program)]), *words],
            env={**os.environ, **environ, "PYTHONPATH": source, "PYTHONUNBUFFERED": "1"},
            cwd=tmp_path,
            text=True,
            **options,
        )
        children.append(child)
        return child

    yield run
    for child in children:
        child.kill()
        child.communicate(timeout=DEADLINE)
