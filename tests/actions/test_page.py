"""The guide's programs with actions."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from pyros1.guide.documents import pages


def programs() -> list[str]:
    return pages()["actions"].code("python")


def start(text: str, environ: dict[str, str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", text],
        env={**os.environ, **environ},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def server(environ: dict[str, str]) -> Iterator[None]:
    with start(programs()[0], environ) as child:
        yield
        child.send_signal(signal.SIGINT)
        assert child.wait(20) == 0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
@pytest.mark.parametrize("number", [1, 2], ids=["node", "asyncio"])
def test_the_programs_of_the_page(server: None, environ: dict[str, str], number: int) -> None:
    with start(programs()[number], environ) as child:
        out, _ = child.communicate(timeout=30)
    assert child.returncode == 0
    assert out.splitlines()[-1] == "result: (0, 1, 1, 2, 3, 5, 8, 13)"
