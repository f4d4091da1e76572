"""The same launch files through stock roslaunch and pyros1: the answers must be the same (X01-X77, L147-L173)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CORPUS = Path(__file__).parent / "launch_corpus"
SOURCES = Path(__file__).parent.parent / "src"
GOOD = sorted(path.stem for path in CORPUS.glob("*.launch"))
BAD = sorted(path.stem for path in (CORPUS / "bad").glob("*.launch"))
ARGUMENTS = {"args": ["needed:=1", "opt:=six", "not_declared:=7"]}
QUERIES = ["--dump-params", "--nodes", "--files", "--ros-args"]
NODE_NAMES = {
    "scopes": ["/a/b/n1", "/c/n2", "/a/d/n3", "/e/n4", "n5"],
    "includes": ["/one/included", "/five/included"],
    "tests_and_machines": ["/n", "m"],
}


def run(tool: list[str], *words: str, cwd: Path) -> tuple[int, str, str]:
    """Run a tool in a folder; return its exit code, stdout and stderr."""
    paths = [str(SOURCES), *filter(None, [os.environ.get("PYTHONPATH")])]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "ROS_HOSTNAME": "localhost"}
    done = subprocess.run([*tool, *words], cwd=cwd, env=env, capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, done.stdout, done.stderr


STOCK = ["/usr/bin/roslaunch"]
OURS = [sys.executable, "-m", "pyros1.cli.launch"]


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("name", GOOD)
def test_query_prints_what_stock_prints(name: str, query: str) -> None:
    words = [query, f"{name}.launch", *ARGUMENTS.get(name, [])]
    code, out, err = run(STOCK, *words, cwd=CORPUS)
    our_code, our_out, our_err = run(OURS, *words, cwd=CORPUS)
    if name == "anon" and query == "--nodes":  # names end in something random
        assert out.rpartition("_")[0].count("_") == our_out.rpartition("_")[0].count("_")
        return
    if query == "--files":  # stock's order is that of a set
        out, our_out = "".join(sorted(out.splitlines(True))), "".join(sorted(our_out.splitlines(True)))
    assert our_out == out, our_err + err
    assert our_code == code


@pytest.mark.parametrize(("name", "node"), [(name, node) for name, nodes in NODE_NAMES.items() for node in nodes])
@pytest.mark.parametrize("query", ["--args", "--find-node"])
def test_questions_about_a_node(name: str, node: str, query: str) -> None:
    words = [f"{query}={node}", f"{name}.launch"]
    code, out, _ = run(STOCK, *words, cwd=CORPUS)
    our_code, our_out, our_err = run(OURS, *words, cwd=CORPUS)
    assert our_out == out, our_err
    assert our_code == code


@pytest.mark.parametrize("name", BAD)
def test_what_stock_refuses_is_refused_with_its_place(name: str) -> None:
    code, out, err = run(STOCK, "--nodes", f"bad/{name}.launch", cwd=CORPUS)
    assert code != 0 and not out, "the corpus says that stock refuses this"
    our_code, our_out, our_err = run(OURS, "--nodes", f"bad/{name}.launch", cwd=CORPUS)
    assert (our_code, our_out) == (1, "")
    assert our_err.startswith("RLException: "), our_err
    assert ".launch:" in our_err.splitlines()[0], our_err
    assert "Traceback" not in our_err
    assert err
