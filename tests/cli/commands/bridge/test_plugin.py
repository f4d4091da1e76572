"""bridge run --dialect: options, files, what is refused, and a running bridge."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.running import run_command
from pyros1.node import Node

Run = Callable[..., tuple[int, str, str]]
DIALECT = ("--dialect", "zenoh-plugin-ros1")


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, partial(run_command, "bridge"))


def test_check_explains(run: Run) -> None:
    words = ["--namespace", "red", "--to", "tcp/localhost:7447", "--send", "/odom", "--call", "/spawn", "--check"]
    code, out, err = run(*DIALECT, *words)
    assert (code, err) == (0, "") and out.splitlines() == [
        "talks to bridges of zenoh-plugin-ros1, in namespace red",
        "  connects to tcp/localhost:7447",
        "sends:",
        "  /odom to namespace red",
        "takes nothing",
        "calls:",
        "  /spawn from namespace red",
    ]


def test_a_file_may_name_the_dialect(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "red.yaml"
    file.write_text("dialect: zenoh-plugin-ros1\nto: tcp/localhost:7447\ntake: [/odom]\n")
    code, out, _ = run("--config", file, "--take", "/scan", "--check")
    assert code == 0 and out.splitlines()[2:] == [
        "sends nothing",
        "takes:",
        "  /scan from bridges of any namespace",
        "  /odom from bridges of any namespace",
    ]
    file.write_text("dialect: zenoh-plugin-ros1\nkeys: red\nlisten: tls/[::]:7447\n")
    code, _, err = run("--config", file)
    assert code == 2 and str(tmp_path / "red") in err, "a path in a file is relative to the file"


@pytest.mark.parametrize(
    ("text", "complaint"), [("robot", "'robot' is not an endpoint"), ("tcp/robot:1", "tcp/robot:1 is not encrypted")]
)
def test_an_endpoint_that_is_refused_in_a_file(run: Run, tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(f"dialect: zenoh-plugin-ros1\nto: {text}\n")
    code, _, err = run("--config", file)
    assert code == 2 and f"ERROR: {file}:2: {complaint}" in err


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--dialect", "other"], "there is no dialect 'other'"),
        ([*DIALECT], "give the endpoint of another bridge with --to"),
        ([*DIALECT, "--site", "red"], "--site is for pyros1 bridges"),
        ([*DIALECT, "--sites", "red"], "--sites is for pyros1 bridges"),
        ([*DIALECT, "--to", "robot"], "is not an endpoint"),
        ([*DIALECT, "--listen", "tcp/0.0.0.0:7447"], "can be reached from other machines"),
        ([*DIALECT, "--to", "tcp/localhost:1", "--namespace", "a-b"], "cannot be a namespace"),
        ([*DIALECT, "--to", "tcp/localhost:1", "--take", "odom"], "is not a pattern"),
        (["--site", "red", "--to", "tcp/localhost:1", "--namespace", "red"], "need --dialect zenoh-plugin-ros1"),
        (["--site", "red", "--to", "tcp/localhost:1", "--old-keys"], "need --dialect zenoh-plugin-ros1"),
    ],
)
def test_what_is_refused(run: Run, words: list[str], complaint: str) -> None:
    code, out, err = run(*words)
    assert code == 2 and out == "" and complaint in err and "Traceback" not in err


@pytest.mark.slow
def test_a_bridge_runs_until_it_is_interrupted(
    run: Run, make_node: Callable[..., Node], environ: dict[str, str], free_port: int
) -> None:
    pytest.importorskip("zenoh")
    endpoint = f"tcp/127.0.0.1:{free_port}"
    command = [sys.executable, "-m", "pyros1", "bridge", *DIALECT, "--listen", endpoint, "--namespace", "red"]
    with subprocess.Popen(command, env={**os.environ, **environ}, stderr=subprocess.PIPE, text=True) as program:
        try:
            assert program.stderr is not None
            assert program.stderr.readline().startswith(f"bridge of zenoh-plugin-ros1 on {endpoint}")
            code, out, _ = run("status")
            assert code == 0 and out.splitlines() == [
                "bridge of zenoh-plugin-ros1, in namespace red",
                "  no topics or services that are taken found yet",
            ]
            program.send_signal(signal.SIGINT)
            assert program.wait(20) in (0, 130, -signal.SIGINT)
        finally:
            program.kill()
