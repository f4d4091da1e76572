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
from pyros1.bag import BagWriter
from pyros1.msgs import Message, load_message

Make = Callable[..., Path]
DEADLINE = 20.0


def header_of(cls: type[Message], **more: str) -> dict[str, bytes]:
    """A connection header, as a publisher sends it."""
    fields = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in fields.items()}


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
        number, text = load_message("std_msgs/Int32"), load_message("std_msgs/String")
        path = tmp_path / name
        writer = BagWriter(path, compression, chunk_threshold)
        a = writer.add_connection("/a", header_of(number, callerid="/talker", latching="1", tcp_nodelay="0"))
        b = writer.add_connection("/b", header_of(text, callerid="/other"))
        for i in range(count):
            time = 100_000_000_000 + i * 10_000_000
            if i % 2:
                writer.write(b, time, text._encode(text(data=str(i))))
            else:
                writer.write(a, time, number._encode(number(data=i)))
        if close:
            writer.close()
        else:
            writer.flush()
            writer.abort()
        return path

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
