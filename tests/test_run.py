"""The command line of ``tests/run``."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a script for bash")
RUN = Path(__file__).with_name("run")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--nope"], "no option '--nope'"),
        (["--quick", "tests/wire"], "what is tests/wire?"),
        (["--units", "--exept", "3.11"], "what is --exept 3.11?"),
        (["--changed", "HEAD", "HEAD~1"], "what is HEAD~1?"),
        (["--units", "--except", "3.11", "3.12"], "what is 3.12?"),
    ],
)
def test_words_that_it_does_not_know_are_refused(words: list[str], complaint: str) -> None:
    """Otherwise it would run something else than what was asked for, for half an hour."""
    done = subprocess.run(["bash", str(RUN), *words], capture_output=True, text=True, timeout=20, check=False)
    assert done.returncode == 2
    assert complaint in done.stderr
