"""Random launch files through stock roslaunch and pyros1: the same parameters, nodes, files, arguments and commands.

What one refuses, the other refuses, too; ours then names the file and line.
"""

from __future__ import annotations

import random
import re
import socket
from pathlib import Path

import pytest
from launch_answers import Answer, ours, stock
from random_launches import Launches, spoil

HOST = re.sub(r"\W", "_", socket.gethostname())
RANDOM_PART = re.compile(rf"_{HOST}_\d+_\d+")
"""Of the names that `$(anon x)` makes."""


def told(answer: Answer, query: str) -> tuple[int, object]:
    """Return what can be compared of an answer."""
    out = RANDOM_PART.sub("_RANDOM", answer.out)
    return answer.code, sorted(out.splitlines()) if query == "--files" else out


@pytest.mark.parametrize("seed", range(25))
def test_random_files_are_read_as_stock_reads_them(tmp_path: Path, seed: int) -> None:
    compare(tmp_path, Launches(random.Random(seed), tmp_path).write())


@pytest.mark.parametrize("seed", range(25))
def test_files_with_mistakes_are_read_or_refused_as_by_stock(tmp_path: Path, seed: int) -> None:
    chance = random.Random(1000 + seed)
    arguments = Launches(chance, tmp_path).write()
    file = chance.choice(sorted(tmp_path.glob("*.launch")))
    file.write_text(spoil(chance, file.read_text()))
    compare(tmp_path, arguments)


def compare(tmp_path: Path, arguments: list[str]) -> None:
    """Ask both about a file: the same answers, or both refuse."""
    queries = ["--nodes", "--dump-params", "--files", "--ros-args"]
    for query in queries:
        theirs, mine = (ask(query, "main.launch", *arguments, cwd=tmp_path) for ask in (stock, ours))
        assert told(mine, query) == told(theirs, query), mine.err + theirs.err
        refused = theirs.code != 0 or "Unable to load" in theirs.err
        assert refused == (mine.code != 0 or "Unable to load" in mine.err), mine.err + theirs.err
        assert not refused or query != "--nodes" or re.search(r"\.launch:\d+: |requires the '\w+' arg", mine.err), (
            mine.err
        )
        assert "Traceback" not in mine.err
        if query == "--nodes":
            queries += [
                f"{question}={node}"
                for node in theirs.out.split()[:3]
                if not RANDOM_PART.search(node)
                for question in ("--args", "--find-node")
            ]
