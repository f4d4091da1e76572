"""The systemd unit of `guide howto master`: its command starts a core, and after kill -9 goes on with what that had."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from configparser import RawConfigParser
from importlib.resources import files
from pathlib import Path
from xmlrpc.client import ServerProxy

import pytest

PATIENCE = 60.0


def unit() -> RawConfigParser:
    """Return the unit of the page."""
    page = files("pyros1.guide").joinpath("howto/master.md").read_text(encoding="utf-8")
    text = page.partition("```ini\n")[2].partition("```")[0]
    found = RawConfigParser()
    found.optionxform = str  # type: ignore[method-assign,assignment]
    found.read_string(text)
    return found


def wait_line(core: subprocess.Popen[str], words: str) -> None:
    assert core.stdout is not None
    lines = []
    for line in core.stdout:
        lines.append(line)
        if words in line:
            return
    raise AssertionError(f"no {words!r} in {lines}")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="systemd and journals are of Linux")
def test_the_unit_starts_the_core_again(tmp_path: Path, free_port: int) -> None:
    service = unit()["Service"]
    assert service["Restart"] == "always" and unit()["Unit"]["StartLimitIntervalSec"] == "0"
    program, *words = shlex.split(service["ExecStart"])
    assert program.endswith("/bin/pyros1") and service["KillSignal"] == "SIGINT"
    command = [sys.executable, "-m", "pyros1", *words, "-p", str(free_port)]
    environ = {**os.environ, "ROS_HOME": str(tmp_path), "ROS_HOSTNAME": "localhost"}
    environ["ROS_MASTER_URI"] = f"http://localhost:{free_port}"

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(command, env=environ, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    core = start()
    try:
        wait_line(core, "started core service")
        with ServerProxy(f"http://localhost:{free_port}/") as master:
            assert master.setParam("/n", "/kept_after_death", 5)[0] == 1  # type: ignore[index]
        until = time.monotonic() + PATIENCE
        journals = (tmp_path / "pyros1").glob
        while not any(b"kept_after_death" in path.read_bytes() for path in journals("master-*.journal")):
            assert time.monotonic() < until
        core.kill()
        core.communicate()
        core = start()
        wait_line(core, "restoring the state of the master that was killed")
        wait_line(core, "started core service")
        with ServerProxy(f"http://localhost:{free_port}/") as master:
            assert master.getParam("/n", "/kept_after_death")[2] == 5  # type: ignore[index]
        core.send_signal(signal.SIGINT)
        assert core.wait(PATIENCE) == 0 and not list(journals("master-*.journal")), "what ended by itself leaves none"
    finally:
        core.kill()
        core.communicate()
