"""bridge keys, and bridge run with them."""

from __future__ import annotations

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
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, partial(run_command, "bridge"))


def test_keys_are_made(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "keys"
    code, out, err = run("keys", folder, "red", "base=base.example,10.0.0.1")
    assert (code, err) == (0, "") and out.splitlines() == [
        f"{folder}/red: the keys of site red",
        f"{folder}/base: the keys of site base, to which others connect at base.example, 10.0.0.1",
        "Copy each folder to its site, as a whole, and start the bridge there with --keys FOLDER.",
        f"Keep {folder}/ca where no site can read it: it makes keys for any name.",
    ]
    assert run("keys", folder, "green")[0] == 0
    code, out, _ = run("keys", folder, "red-2")
    assert code == 0 and out.splitlines()[:2] == [
        f"{folder}/red-2: the keys of site red",
        "To shut the older keys of red out, write red-2 in place of them under --sites or `sites` where others "
        "connect, and start these bridges and routers again.",
    ]
    assert sorted(path.name for path in folder.iterdir()) == ["base", "ca", "green", "red", "red-2"]


@pytest.mark.parametrize(
    ("words", "code", "complaint"),
    [
        (["FOLDER"], 2, "name a folder for the keys, and the sites"),
        (["FOLDER", "red", "red=a"], 2, "ERROR: site red is named twice"),
        (["FOLDER", "r-d"], 1, "ERROR: 'r-d' cannot be a site's name"),
        (["FOLDER", "base=a b"], 1, "ERROR: 'a b' is neither a host name nor an IP address"),
        (["FOLDER", "base="], 1, "ERROR: '' is neither a host name nor an IP address"),
        (["FOLDER", "red", "--days", "0"], 1, "ERROR: certificates can be valid for 1 to 36500 days, not for 0"),
    ],
)
def test_mistakes(run: Run, tmp_path: Path, words: list[str], code: int, complaint: str) -> None:
    found, out, err = run("keys", *(word.replace("FOLDER", f"{tmp_path}/keys") for word in words))
    assert (found, out) == (code, "") and complaint in err and "Traceback" not in err
    assert not (tmp_path / "keys").exists()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--keys", "FOLDER/green"], "green has the keys of site green, not of red"),
        (["--keys", "FOLDER/blue"], "blue has no site.key: make keys with `pyros1 bridge keys`, and give this site's"),
        ([], "tls/127.0.0.1:1 needs keys: make them with `pyros1 bridge keys`"),
        (["--keys", "FOLDER/red", "--sites", "r-d"], "'r-d' cannot be a site's name"),
        (
            ["--keys", "FOLDER/red", "--sites", "green-2"],
            "about green-2 applies only where other sites connect: give",
        ),
        (["--keys", "FOLDER/red", "--to", "tls/[::1]:1"], "zenoh connects by TLS to host names and IPv4 addresses"),
        (["--keys", "FOLDER/red", "--to", "tcp/base:1"], "tcp/base:1 cannot use the keys: use tls/base:1"),
    ],
)
def test_keys_that_do_not_fit(run: Run, tmp_path: Path, words: list[str], complaint: str) -> None:
    make_keys(tmp_path, {"red": [], "green": []})
    (tmp_path / "blue").mkdir()
    for name in ("ca.crt", "site.crt"):
        (tmp_path / "blue" / name).write_bytes((tmp_path / "red" / name).read_bytes())
    code, _, err = run(
        "--site", "red", "--to", "tls/127.0.0.1:1", *(word.replace("FOLDER", str(tmp_path)) for word in words)
    )
    assert code == 2 and complaint in err


def test_a_path_in_a_file_is_relative_to_it(run: Run, tmp_path: Path) -> None:
    (tmp_path / "red.yaml").write_text("site: red\nto: tls/base:1\nkeys: keys/red\nsites: [base]\n")
    code, out, err = run("--config", tmp_path / "red.yaml", "--check", "--sites", "far")
    assert code == 0 and err.startswith("WARNING: ") and f"{tmp_path}/keys/red" in err, "they may be elsewhere"
    assert f"  proves its name with the keys in {tmp_path}/keys/red, and requires certificates from others" in out
    assert "talks to the sites base, far" in out


def test_keys_that_expire_soon_and_a_listener_for_all(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")  # nothing starts
    make_keys(tmp_path, {"red": ["127.0.0.1"]}, days=30)
    words = ["--site", "red", "--keys", tmp_path / "red", "--listen", "tls/127.0.0.1:0"]
    _, _, err = run(*words)
    assert f"WARNING: the keys in {tmp_path}/red expire in 29 days" in err
    assert "WARNING: no sites are named with --sites, so any site with keys can impersonate another one here" in err
    assert "impersonate" not in run(*words, "--sites", "green")[2]
    file = tmp_path / "red.yaml"
    file.write_text("site: red\nsites: {green: {forwards: [far]}}\n")
    forwarding = run(*words, "--config", file, "--to", "tls/localhost:1")
    assert "hear" not in forwarding[2] and "impersonate" not in forwarding[2]
    both = run(*words, "--sites", "green", "--to", "tls/127.0.0.1:1")
    assert "WARNING: no site in `sites` forwards others, so only sites are heard that connect here" in both[2]
