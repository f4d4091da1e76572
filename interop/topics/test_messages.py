"""Message classes against genmsg and genpy, for every type that Debian ships (G01-G26, O06, O07, O24).

The comparison runs in a Python that has the stock packages; here its reports are judged.

Feature: MD5 sums and definitions equal stock's -- every type that Debian ships
"""

from __future__ import annotations

import json
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

PEER = Path(__file__).parents[1] / "peers" / "messages_peer.py"
DEFINITIONS_PEER = PEER.with_name("definitions_peer.py")
SOURCE = Path(__file__).parents[2] / "src"
STOCK_PYTHON = "/usr/bin/python3"


def report(*args: str, peer: Path = PEER) -> dict[str, Any]:
    """Run a peer and return its report."""
    done = subprocess.run(
        [STOCK_PYTHON, str(peer), *args],
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def test_md5_and_full_text_of_every_type_and_the_shipped_copies() -> None:
    result = report("sums")
    assert result["failures"] == []
    assert result["count"]["messages"] >= 162
    assert result["count"]["services"] >= 25
    assert result["count"]["shipped"] == result["count"]["messages"] + result["count"]["services"]
    assert result["count"]["from actions"] >= 28


def test_random_values_of_every_type_both_ways_printed_and_filled() -> None:
    result = report("values", "20")
    assert result["failures"] == []
    assert result["count"]["types"] >= 162 + 2 * 25
    assert result["count"]["values"] == 20 * result["count"]["types"]
    assert result["count"]["filled"] > result["count"]["types"]


def test_random_definitions_and_values_of_them(request: pytest.FixtureRequest) -> None:
    """With ``--long`` ten times as many.

    Feature: definitions of any shape: bytes, text and MD5 sums equal those of genpy and genmsg -- 2,000
        random definitions per run
    """
    half = 2000 if request.config.getoption("--long") else 200
    with ThreadPoolExecutor() as pool:
        results = list(pool.map(lambda first: report(str(first), str(half), peer=DEFINITIONS_PEER), [0, half]))
    assert [failure for result in results for failure in result["failures"]] == []
    assert sum(result["count"]["definitions"] for result in results) == 2 * half
    assert sum(result["count"]["times"] for result in results) > half
    assert sum(result["count"]["cut and received"] for result in results) > half // 4
    assert (
        sum(result["count"]["values"] for result in results) >= 3.6 * half
    )  # genpy's own code is wrong for some names


def test_strings_are_printed_as_yaml_alike() -> None:
    assert report("strings", "20000")["failures"] == []


def test_l40_l41_hidden_strings_and_arrays() -> None:
    result = report("hidden")
    assert result["failures"] == []
    assert result["count"]["types"] >= 100


@pytest.mark.parametrize("lines", ["Float64 ", "Twist ", "JointState(7) ", "PointCloud2(1 MB) "])
def test_the_codec_benchmark_runs(benchmark_output: str, lines: str) -> None:
    assert any(line.startswith(lines) and "x)" in line for line in benchmark_output.splitlines())


@pytest.fixture(scope="module")
def benchmark_output() -> str:
    """What the codec benchmark prints; it checks itself that both encodings are equal."""
    return subprocess.run(
        [STOCK_PYTHON, str(PEER.parent.parent / "bench" / "codec.py")],
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    ).stdout
