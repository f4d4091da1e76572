"""A browser and the server of the page, for tests."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web, start_chromium
from harness import stacks

from pyros1.master.server import Master
from pyros1.node import Node

collect_ignore = [] if os.environ.get("PYROS1_BAGS") else ["test_real_bags.py"]


@pytest.fixture
def ros_master() -> Iterator[Master]:
    """A master of pyros1 on a free port, for one test."""
    server = Master(port=0, bind_host="127.0.0.1")
    server.start()
    yield server
    server.stop()


@pytest.fixture
def environ(ros_master: Master, tmp_path: Path) -> dict[str, str]:
    """Environment variables for the programs of a test."""
    return {"ROS_MASTER_URI": ros_master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(tmp_path / "ros")}


@pytest.fixture
def make_node(environ: dict[str, str]) -> Iterator[Callable[..., Node]]:
    """Return a function that makes nodes in the test's process."""
    nodes: list[Node] = []

    def make(name: str, **options: Any) -> Node:
        nodes.append(Node(name, argv=[], environ=environ, handle_signals=False, **options))
        return nodes[-1]

    yield make
    for node in nodes:
        node.shutdown()


@pytest.fixture(scope="session")
def _driver() -> Iterator[Any]:
    if not shutil.which("chromium") or not shutil.which("chromedriver"):
        if os.environ.get("PYROS1_REQUIRE_STOCK"):
            pytest.fail("chromium and chromedriver are missing: interop/setup installs them")
        pytest.skip("chromium and chromedriver are not installed")
    with start_chromium() as driver:
        yield driver


@pytest.fixture
def browser(_driver: Any, start_web: Callable[..., Web]) -> Iterator[Browser]:
    """A browser, for pages of servers that end after it. The page may not complain in the browser's console."""
    found = Browser(_driver)
    found.complaints()
    yield found
    complaints = found.complaints()
    found.driver.get("about:blank")
    _driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert not complaints, complaints


@pytest.fixture
def start_web(environ: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., Web]]:
    """Return a function that starts ``pyros1 web`` with more words, on a free port."""
    processes: list[subprocess.Popen[str]] = []

    def start(*words: str) -> Web:
        process = subprocess.Popen(
            [sys.executable, "-m", "pyros1", "web", "--port", "0", *words],
            env={**os.environ, **environ},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
        )
        processes.append(process)
        assert process.stdout is not None
        line = process.stdout.readline()
        match = re.search(r"http://\S+\Z", line.strip())
        assert match, line
        return Web(process, match[0])

    yield start
    for process in processes:
        process.terminate()
        try:
            rest, _ = process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            where = stacks(process.pid)
            process.kill()
            rest, _ = process.communicate()
            raise AssertionError(f"pyros1 web did not end within 30 s of SIGTERM: {rest}\n{where}") from None
        assert "Traceback" not in rest, rest


@pytest.fixture
def web(start_web: Callable[..., Web]) -> Web:
    """A running ``pyros1 web`` that shows the system of the test's master."""
    return start_web()


@pytest.fixture
def start_program(environ: dict[str, str]) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Return a function that runs ``pyros1`` with some words until the test ends."""
    processes: list[subprocess.Popen[bytes]] = []

    def start(*words: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", "pyros1", *words],
            env={**os.environ, **environ},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.terminate()
    until = time.monotonic() + 30
    for process in processes:
        process.wait(max(0.1, until - time.monotonic()))
