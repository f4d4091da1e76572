"""bridge run: options, files, and what is refused.

Feature: `pyros1 bridge` connects masters; `--check` explains what would be sent and received
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

from pyros1.cli.running import run_command
from pyros1.node import Node

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, partial(run_command, "bridge"))


def test_check_explains(run: Run) -> None:
    words = [
        "--site",
        "red",
        "--to",
        "tcp/localhost:7447",
        "--send",
        "/odom",
        "/scan@5",
        "--take",
        "/cmd_vel",
        "--check",
    ]
    code, out, err = run(*words)
    assert "  considers a site lost that has not responded for 1.5 s\n" in run(*words, "--loss", "1.5")[1]
    assert (code, err) == (0, "") and out.splitlines() == [
        "site red: talks to all sites",
        "  connects to tcp/localhost:7447",
        "sends:",
        "  /odom to every site that takes it",
        "  /scan to every site that takes it, at most 5 messages per second",
        "takes:",
        "  /cmd_vel, from every site that sends it here",
    ]
    assert run("run", *words) == (code, out, err)


def test_a_misspelt_site(run: Run) -> None:
    words = ["--site", "base", "--to", "tcp/localhost:7447", "--sites", "green", "--take", "grn:**", "--check"]
    code, _, err = run(*words)
    text = "WARNING: rules name site grn, but `sites` does not (did you mean 'green'?): nothing is exchanged with it\n"
    assert (code, err) == (0, text)


def test_a_file_and_the_command_line(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "red.yaml"
    file.write_text("site: red\nto: tcp/localhost:7447\nsend: [/odom]\n")
    code, out, _ = run("--config", file, "--send", "/scan", "--send", "!/odom", "--check", "--listen", "tcp/[::1]:7447")
    assert code == 0 and "  listens on tcp/[::1]:7447" in out
    assert out.index("  /scan to") < out.index("  /odom to") < out.index("  never /odom")


def test_services_and_parameters(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "red.yaml"
    file.write_text("site: red\nto: tcp/localhost:7447\nserve: [/add]\ncall: ['base:/add']\nparams: [/a]\n")
    words = ["--serve", "/set_map", "!/secret", "--call", "base:**", "--params", "/b", "!/a/x"]
    code, out, _ = run("--config", file, *words, "--check")
    assert code == 0 and out.splitlines()[4:] == [
        "lets others call:",
        "  /set_map, by every site that calls it",
        "  /add, by every site that calls it",
        "  never /secret",
        "provides services of others:",
        "  /** of base, as /base/** here",
        "  /add of base, as /base/add here",
        "lets others read the parameters:",
        "  /b and all below it",
        "  /a and all below it",
        "  never /a/x",
    ]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--site", "red", "--to", "tcp/base:1", "--serve", "red:/a"], "ERROR: 'red:/a' is another site's"),
        (["--site", "red", "--to", "tcp/base:1", "--call", "/a"], "ERROR: '/a' does not say whose service it is"),
        (["--site", "red", "--to", "tcp/base:1", "--params", "a"], "ERROR: 'a' is not a pattern of parameters"),
        (["--site", "red"], "give the endpoint of another site with --to, or one to listen on with --listen"),
        (["--to", "tcp/base:1"], "name this site with --site, or give a file with --config"),
        (["--site", "r-d", "--to", "tcp/base:1"], "ERROR: 'r-d' cannot be a site's name"),
        (["--site", "red", "--to", "base"], "ERROR: 'base' is not an endpoint"),
        (
            ["--site", "red", "--listen", "tcp/0.0.0.0:7447"],
            "ERROR: tcp/0.0.0.0:7447 can be reached from other machines",
        ),
        (["--site", "red", "--listen", "udp/[::]:7447"], "Use tls/[::]:7447 with --keys, or allow it with --insecure"),
        (["--site", "red", "--listen", "tls/[::]:7447", "--insecure"], "needs keys"),
        (["--site", "red", "--to", "tcp/base:1", "--send", "odom"], "ERROR: 'odom' is not a pattern of topics"),
        (["--site", "red", "--to", "tcp/base:1", "--take", "/a@fast"], "the rate after @ must be a number above 0"),
        (["--site", "red", "--to", "tcp/base:1", "--loss", "0.5"], "ERROR: loss must be a number of seconds from 1"),
        (["--site"], "expected one argument"),
        (["--sit\x1b"], "unrecognized arguments"),
        (["--site", "red", "--sned", "/odom"], "unrecognized arguments: --sned /odom (did you mean '--send'?)"),
        (["--site", "red", "--kyes=folder"], "unrecognized arguments: --kyes=folder (did you mean '--keys'?)"),
    ],
)
def test_what_is_refused(run: Run, words: list[str], complaint: str) -> None:
    code, out, err = run(*words)
    assert code == 2 and out == "" and complaint in err and "Traceback" not in err


def test_files_that_cannot_be_used(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text("site: red\nsand: []\n")
    code, _, err = run("--config", file, "--check")
    assert code == 2 and f"ERROR: {file}:2: there is no setting 'sand' (did you mean 'send'?)" in err
    file.write_text("site: [\n")
    code, _, err = run("--config", file, "--check")
    assert code == 2 and f"ERROR: {file}:" in err
    file.write_bytes(b"site: red\n#" + b"x" * (1 << 20))
    assert run("--config", file, "--check")[0] == 2


def test_help(run: Run) -> None:
    code, out, _ = run("-h")
    assert code == 0 and "status" in out and "--site NAME" in out
    assert run()[0] == 64
    code, out, _ = run("run", "-h")
    assert code == 0 and "--insecure" in out and "Examples:" in out


def test_without_zenoh(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.transport.zenoh_link.find_spec", lambda name: None)
    code, _, err = run("--site", "red", "--to", "tcp/127.0.0.1:1")
    assert code == 1 and "pip install 'pyros1[bridge]'" in err


def test_without_what_a_conversion_needs(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("zenoh")

    def fail(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr("pyros1.observe.image_files.import_module", fail)
    file = tmp_path / "red.yaml"
    file.write_text("{site: red, to: tcp/127.0.0.1:1, send: [{topic: /a, convert: jpeg}]}")
    code, _, err = run("--config", str(file))
    assert code == 1 and "pip install 'pyros1[images]'" in err


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch, free_port: int) -> None:
    pytest.importorskip("zenoh")
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{free_port}")
    code, _, err = run("--site", "red", "--to", "tcp/127.0.0.1:1")
    assert code == 1 and "Unable to communicate with master" in err


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_bridge_runs_until_it_is_interrupted(
    run: Run, make_node: Callable[..., Node], environ: dict[str, str], free_port: int, number: int
) -> None:
    pytest.importorskip("zenoh")
    command = [sys.executable, "-m", "pyros1", "bridge", "--site", "red", "--listen", f"tcp/127.0.0.1:{free_port}"]
    with subprocess.Popen(command, env={**os.environ, **environ}, stderr=subprocess.PIPE, text=True) as program:
        try:
            assert program.stderr is not None
            assert program.stderr.readline().startswith(f"site red on tcp/127.0.0.1:{free_port}")
            assert run("status") == (0, "site red\n  no other site found yet\n", "")
            code, out, _ = run("status", "--json")
            assert code == 0 and '"site": "red"' in out
            program.send_signal(number)
            assert program.wait(20) in (0, 130, -signal.SIGINT)
        finally:
            program.kill()


def test_a_file_that_is_no_text(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "red.yaml"
    file.write_bytes(b"site: red\nto: \xff\n")
    error = f"ERROR: {file}:2: this is not UTF-8 text; save the file as UTF-8\n"
    assert run("--config", file, "--check") == (2, "", error)


def test_a_misspelt_verb(run: Run) -> None:
    code, _, err = run("statsu")
    assert code == 64 and err == "pyros1 bridge: unknown command 'statsu' (did you mean 'status'?)\n"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("listen: tcp/0.0.0.0:7447\n", ":2: tcp/0.0.0.0:7447 can be reached from other machines"),
        ("to:\n- tcp/localhost:1\n- tcp/base:1\n", ":4: tcp/base:1 is not encrypted"),
        ("to: tls/base:1\n", ":2: tls/base:1 needs keys"),
        ("keys: a\nto: tls/[::1]:1\n", ":3: tls/[::1]:1: zenoh connects by TLS to host names"),
        ("to: tcp/localhost:1\nsites: [base, blue-2]\n", ":3: what `sites` says about blue-2 applies only where"),
        (
            "listen: tcp/localhost:1\nsites:\n  blue:\n  base: {send: [/a]}\n",
            ":5: what `sites` says about base needs keys",
        ),
    ],
)
def test_what_is_refused_in_a_file_names_the_line(run: Run, tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "red.yaml"
    file.write_text(f"site: red\n{text}")
    code, out, err = run("--config", file, "--check")
    assert (code, out) == (2, "") and f"ERROR: {file}{complaint}" in err
