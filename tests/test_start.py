"""Nothing heavy is imported before it is used: what programs and commands load by the time that they run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / "src"

LIBRARIES = {
    "apsw",
    "av",
    "backports",
    "cryptography",
    "lz4",
    "numpy",
    "PIL",
    "rosbags",
    "ruamel",
    "websockets",
    "xacro",
}
LIBRARIES |= {"yaml"}
"""What pyros1 is installed with, or may be, but for defusedxml, which reads launch files."""
SLOW = {"asyncio", "email", "hashlib", "http", "logging", "multiprocessing", "ssl", "unittest"}
"""Modules of Python that take longer than most commands of ours. hashlib loads OpenSSL: 4 MB of memory."""
XML = {"defusedxml", "urllib", "xml"}
DEADLINE = 60.0

Environ = dict[str, str]


@pytest.fixture
def env(environ: Environ, tmp_path: Path) -> Environ:
    """The environment of a process that finds the test's master."""
    home = {"PYTHONPATH": str(SOURCES), "ROS_HOME": str(tmp_path / "ros"), "ROS_PACKAGE_PATH": ""}
    return {**os.environ, **environ, **home}


def imported(output: str) -> set[str]:
    """Return the top-level modules of a report by ``-X importtime``."""
    rows = (line for line in output.splitlines() if line.startswith("import time:"))
    return {row.rpartition("|")[2].strip().partition(".")[0] for row in rows}


@pytest.fixture
def load(env: Environ) -> Callable[..., set[str]]:
    """Return a function that runs Python and returns the top-level modules that it has loaded."""

    def run(*words: str) -> set[str]:
        command = [sys.executable, "-X", "importtime", *words]
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=DEADLINE, check=True)
        return imported(done.stderr)

    return run


def test_importing_pyros1(load: Callable[..., set[str]]) -> None:
    loaded = load("-c", "import pyros1")
    assert "pyros1" in loaded and not loaded & (LIBRARIES | SLOW | XML | {"socket", "threading", "struct"})


def test_a_small_node(load: Callable[..., set[str]]) -> None:
    program = (
        "import pyros1; from pyros1.msgs.std_msgs.msg import String\n"
        "with pyros1.Node('talker') as node: node.advertise('word', String, queue_size=1).publish(String('hello'))"
    )
    loaded = load("-c", program)
    assert "socket" in loaded and not loaded & (LIBRARIES | SLOW | XML)


@pytest.mark.parametrize("words", ["topic list", "node list", "param list", "topic -h", "core -h", "bag -h"])
def test_a_command(load: Callable[..., set[str]], words: str) -> None:
    loaded = load("-m", "pyros1", *words.split())
    assert "pyros1" in loaded and not loaded & (LIBRARIES | SLOW | XML)


@pytest.mark.slow
def test_help_of_verbs(load: Callable[..., set[str]]) -> None:
    """All records need neither a library nor a node, so that help and wrong words are answered soon."""
    program = (
        "import sys; from pyros1.cli import registry\n"
        "records = [registry.load_verb(name, verb) for name in registry.commands() for verb in registry.verbs(name)]\n"
        "sys.exit('pyros1.node' in sys.modules or len(records) < 100)"
    )
    assert not load("-c", program) & LIBRARIES


@pytest.mark.parametrize("options", [[], ["--nodes"]])
def test_launch(load: Callable[..., set[str]], tmp_path: Path, options: list[str]) -> None:
    file = tmp_path / "a.launch"
    file.write_text('<launch><param name="p" value="1"/></launch>')
    loaded = load("-m", "pyros1", "launch", *options, str(file))
    assert "defusedxml" in loaded and not loaded & (LIBRARIES | SLOW)


def test_core(env: Environ, free_port: int, tmp_path: Path) -> None:
    command = [sys.executable, "-X", "importtime", "-m", "pyros1", "core", "-p", str(free_port)]
    report = tmp_path / "report"
    with (
        report.open("w") as errors,
        subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=errors, text=True) as process,
    ):
        assert process.stdout is not None
        try:
            assert any("started core service" in line for line in process.stdout)
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=DEADLINE)
    loaded = imported(report.read_text())
    assert process.returncode == 0 and "socket" in loaded and not loaded & (LIBRARIES | SLOW)
