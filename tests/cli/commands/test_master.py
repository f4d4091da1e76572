"""pyros1 master: the master alone (L20)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from pyros1.cli.main import entry
from pyros1.ground.errors import MasterUnreachableError
from pyros1.master import Master
from pyros1.net.master_client import MasterClient


def test_it_runs_until_it_is_told_to_end(free_port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process, so the end is asked for by the master's own API."""
    monkeypatch.setenv("ROS_HOSTNAME", "127.0.0.1")
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    uri = f"http://127.0.0.1:{free_port}/"
    seen: list[object] = []

    def ask() -> None:
        client = MasterClient("/test", uri)
        while not seen:
            with suppress(MasterUnreachableError):  # not yet
                seen.append(client.get_pid())
        client.call("shutdown", "enough")
        client.close()

    asking = threading.Thread(target=ask)
    asking.start()
    log = tmp_path / "logs" / "master.log"
    try:
        assert entry(["pyros1", "master", "--core", "-p", str(free_port), f"__log:={log}"]) == 0
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        asking.join(10)
    assert seen == [os.getpid()]
    assert f"port[{free_port}]" in log.read_text()


def test_another_master_is_there(master: Master, tmp_path: Path) -> None:
    port = urlsplit(master.uri).port
    done = subprocess.run(
        [sys.executable, "-c", f"from pyros1.cli.main import entry; entry(['pyros1', 'master', '-p', '{port}'])"],
        env={**os.environ, "ROS_HOSTNAME": "127.0.0.1", "ROS_LOG_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert "the port is in use, by another master or " in done.stderr


def test_wrong_words(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["x"], ["--master-logger-level", "loud"], ["-p", "70000"], ["-p", "-1"]):
        with pytest.raises(SystemExit, match="2"):
            entry(["pyros1", "master", *words])
    err = capsys.readouterr().err
    assert "unrecognized args: x" in err and "the port must be from 1 to 65535, not 70000\n" in err


@pytest.mark.parametrize("port", ["-1", "0", "70000"])
def test_a_core_says_which_ports_there_are(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert entry(["pyros1", "core", "-p", port]) == 1
    assert capsys.readouterr().err == f"RLException: the port must be from 1 to 65535, not {port}\n"
