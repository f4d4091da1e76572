"""bridge router: options, files, what is refused, and a router that runs.

Feature: `pyros1 bridge router` runs a router alone, on a server to which all sites connect
"""

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

from pyros1.bridge.transport.certificates import make_keys
from pyros1.cli.running import run_command

pytest.importorskip("cryptography")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(call_main: Any) -> Run:
    return partial(call_main, partial(run_command, "bridge"), "router")


def test_check_explains(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "fleet.yaml"
    file.write_text("listen: tls/[::]:7447\nkeys: keys/router\nsites: {red: {send: [/odom]}, base: }\n")
    code, out, err = run("--config", file, "--check", "--sites", "red", "green", "--to", "tls/hub.example:7447")
    assert (code, err) == (0, "") and out.splitlines() == [
        "a router for red, base, green",
        "  connects to tls/hub.example:7447",
        "  listens on tls/[::]:7447",
        f"  proves its name with the keys in {tmp_path}/keys/router, and requires certificates from others",
        "  red may send /odom",  # the file still counts
        "  red may take nothing",
        "  red may serve nothing",
        "  red may call nothing",
    ]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "give an endpoint to listen on with --listen"),
        (["--listen", "tcp/[::]:7447"], "ERROR: tcp/[::]:7447 can be reached from other machines"),
        (["--listen", "tls/[::]:7447"], "ERROR: tls/[::]:7447 needs keys"),
        (["--listen", "tls/[::]:7447", "--keys", "FOLDER"], "ERROR: FOLDER has no ca.crt and no site.crt and"),
        (["--listen", "nowhere"], "ERROR: 'nowhere' is not an endpoint"),
        (["--listen", "tcp/127.0.0.1:1", "--sites", "r-d"], "ERROR: 'r-d' cannot be a site's name"),
        (["--listen", "tcp/127.0.0.1:1", "--sites", "red-2"], "ERROR: what `sites` says about red-2 needs keys"),
        (["--config", "FOLDER/bad.yaml"], "ERROR: FOLDER/bad.yaml:1: there is no setting 'site'"),
        (["--config", "FOLDER/open.yaml"], "ERROR: FOLDER/open.yaml:2: tcp/[::]:7447 can be reached from other"),
        (
            ["--listen", "tls/[::]:7447", "--to", "tls/[::1]:7447", "--keys", "FOLDER"],
            "ERROR: tls/[::1]:7447: zenoh connects by TLS to host names and IPv4 addresses only",
        ),
        (["--send", "/odom"], "unrecognized arguments"),
    ],
)
def test_what_is_refused(run: Run, tmp_path: Path, words: list[str], complaint: str) -> None:
    (tmp_path / "bad.yaml").write_text("site: red\n")
    (tmp_path / "open.yaml").write_text("sites: [red]\nlisten: tcp/[::]:7447\n")
    code, out, err = run(*(word.replace("FOLDER", str(tmp_path)) for word in words))
    assert code == 2 and out == "" and complaint.replace("FOLDER", str(tmp_path)) in err and "Traceback" not in err


def test_a_port_that_is_taken(run: Run) -> None:
    pytest.importorskip("zenoh")
    code, _, err = run("--listen", "tcp/192.0.2.1:7447", "--insecure")  # no address of this machine
    assert code == 1 and err.startswith("ERROR: cannot start the router: ")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_router_runs_until_it_is_interrupted(tmp_path: Path, free_port: int, number: int) -> None:
    zenoh = pytest.importorskip("zenoh")
    from pyros1.bridge.transport.access_control import security_settings
    from pyros1.bridge.transport.certificates import load_keys
    from pyros1.bridge.transport.zenoh_link import make_config

    make_keys(tmp_path, {"router": ["127.0.0.1"], "red": [], "stranger": []})
    endpoint = f"tls/127.0.0.1:{free_port}"
    command = [sys.executable, "-m", "pyros1", "bridge", "router", "--listen", endpoint]
    command += ["--keys", str(tmp_path / "router"), "--sites", "red"]
    with subprocess.Popen(
        command, env={**os.environ}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as program:
        sessions = []
        try:
            assert program.stdout is not None
            assert program.stdout.readline() == f"router on {endpoint}\n"
            for name, line in (("red", "site red connected (127.0.0.1:"), ("stranger", "WARNING: site stranger conn")):
                settings = security_settings(load_keys(tmp_path / name), ())
                sessions.append(zenoh.open(make_config(zenoh, "client", [endpoint], [], settings)))
                assert program.stdout.readline().startswith(line)
            sessions.pop(0).close()
            assert program.stdout.readline().startswith("site red disconnected (127.0.0.1:")
            program.send_signal(number)  # one is still connected
            assert program.wait(20) == 0 and program.stdout.read() == ""
        finally:
            program.kill()
            for session in sessions:
                session.close()
