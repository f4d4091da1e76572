"""rosversion, rosclean, rosgraph and rosconsole against ours: same command line, same output and exit code (L176-L180).

Texts of help and of errors on stderr are ours.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import pytest
from harness import SOURCE, Master, Peer, until, without_thread_errors

OWN_MASTER = True

LIMIT = 15.0
"""Seconds for programs that do not end by themselves."""
Answer = tuple[int, str, str]


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tools")
    for name in ("rosversion", "rosclean", "rosgraph", "rosconsole"):
        tool = folder / name
        start = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); from pyros1.cli.main import entry; sys.exit(entry())"
        tool.write_text(f"#!{sys.executable}\n{start}\n")
        tool.chmod(0o755)
    return folder


@pytest.fixture
def talker(launcher: Master) -> Iterator[Peer]:
    """A stock node."""
    peer = launcher.ready_peer("rospy", "misc_talker")
    yield peer
    peer.quit()


def ask(program: Path, words: list[str], environ: dict[str, str], stdin: str = "") -> Answer:
    # Stock's rosconsole waits for ever where there is no master, and rosgraph in any case.
    command = ["timeout", "-s", "INT", "-k", "2", str(LIMIT), str(program), *words]
    done = subprocess.run(
        command, env=environ, input=stdin.encode(), capture_output=True, timeout=LIMIT + 30, check=False
    )
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def both(tools: Path, command: str, environ: dict[str, str], stdin: str = "") -> tuple[Answer, Answer]:
    program, *words = command.split()
    with ThreadPoolExecutor(2) as pool:
        stock = pool.submit(ask, Path("/usr/bin") / program, words, environ, stdin)
        ours = pool.submit(ask, tools / program, words, environ, stdin)
    code, out, err = stock.result()
    return (code, out, without_thread_errors(err)), ours.result()


VERSION = [
    "rosversion",
    "rosversion -d",
    "rosversion -s -d",
    "rosversion rospy",
    "rosversion -s roscpp",
    "rosversion std_msgs -s",
    "rosversion nope",
    "rosversion a b",
    "rosversion -a -d",
    "rosversion rospy -d",
    "rosversion -a rospy",
    "rosversion -q",
]


@pytest.mark.parametrize("distro", ["noetic", ""])
@pytest.mark.parametrize("command", VERSION)
def test_rosversion_l180(tools: Path, command: str, distro: str) -> None:
    environ = {"PATH": os.environ["PATH"], "ROS_PACKAGE_PATH": "/usr/share", "LANG": "C.UTF-8"}
    stock, ours = both(tools, command, environ | ({"ROS_DISTRO": distro} if distro else {}))
    assert ours[:2] == stock[:2]
    assert bool(ours[2]) == bool(stock[2])


def test_rosversion_of_all_l180(tools: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ours are sorted, and what comes with pyros1 is among them."""
    environ = {"PATH": os.environ["PATH"], "ROS_PACKAGE_PATH": "/usr/share", "LANG": "C.UTF-8"}
    monkeypatch.setitem(globals(), "LIMIT", 25.0)  # stock reads them all
    stock, ours = both(tools, "rosversion -a", environ)
    assert set(stock[1].splitlines()) <= set(ours[1].splitlines()) and ours[0] == stock[0]


CLEAN = [
    ("rosclean", ""),
    ("rosclean check", ""),
    ("rosclean check x", ""),
    ("rosclean bogus", ""),
    ("rosclean purge", "n\nn\n"),
    ("rosclean purge", "what\ny\nY\n"),
    ("rosclean purge -y", ""),
    ("rosclean purge --size", ""),
    ("rosclean purge --size x", ""),
    ("rosclean purge --size 9", ""),
    ("rosclean purge --size 5", "n\n"),
    ("rosclean purge --size 5", "y\n"),
    ("rosclean purge --size 2 -y", ""),
    ("rosclean purge --size 0 -y", ""),
    ("rosclean purge --size -1 -y", ""),
]


@pytest.mark.parametrize(("command", "stdin"), CLEAN)
def test_rosclean_l179(tools: Path, tmp_path: Path, command: str, stdin: str) -> None:
    """The same lines, and the same files are left."""
    results = []
    program, *words = command.split()
    for place, folder in ((Path("/usr/bin"), tmp_path / "stock"), (tools, tmp_path / "ours")):
        logs = folder / "log"
        (logs / "run 1").mkdir(parents=True)
        (folder / "rosmake").mkdir()
        for age, name in enumerate(("c", "run 1/b", "a")):
            (logs / name).write_bytes(b"x" * 2_500_000)
            os.utime(logs / name, (1e9 - age, 1e9 - age))
        os.utime(logs / "run 1", (1e9 - 1, 1e9 - 1))
        environ = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "ROS_HOME": str(folder), "LANG": "C.UTF-8"}
        code, out, _ = ask(place / program, words, environ, stdin)
        results.append(
            (code, out.replace(str(folder), "FOLDER"), sorted(str(p)[len(str(folder)) :] for p in folder.rglob("*")))
        )
    assert results[1] == results[0]


CONSOLE = [
    "rosconsole",
    "rosconsole bogus",
    "rosconsole -h",
    "rosconsole list",
    "rosconsole list /misc_talker",
    "rosconsole list misc_talker",
    "rosconsole list /nope",
    "rosconsole list a b",
    "rosconsole get",
    "rosconsole get /misc_talker rosout",
    "rosconsole get /misc_talker rospy",
    "rosconsole get /misc_talker nope",
    "rosconsole get /nope x",
    "rosconsole set /misc_talker rosout WARN",
    "rosconsole get /misc_talker rosout",
    "rosconsole set /misc_talker rosout loud",
    "rosconsole set /misc_talker nope warn",
    "rosconsole set /nope rosout warn",
    "rosconsole set /misc_talker",
    "rosconsole echo a b",
    "rosconsole echo -l loud",
]


def test_rosconsole_l176(tools: Path, launcher: Master, talker: Peer) -> None:
    for command in CONSOLE:
        stock, ours = both(tools, command, launcher.environ())
        assert (command, *ours[:2]) == (command, *stock[:2])
        assert bool(ours[2]) == bool(stock[2])


def test_rosconsole_echo_l176(tools: Path, launcher: Master, talker: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stock's has colours in a pipe, and bold names even with --nocolor; ours has them on a terminal only."""
    monkeypatch.setitem(globals(), "LIMIT", 25.0)
    for command in ("rosconsole echo -1 --nocolor misc", "rosconsole echo --once -l error --topic /rosout --nocolor"):
        program, *words = command.split()
        with ThreadPoolExecutor(2) as pool:
            stock = pool.submit(ask, Path("/usr/bin") / program, words, launcher.environ())
            ours = pool.submit(ask, tools / program, words, launcher.environ())
            while not (stock.done() and ours.done()):
                talker.tell("log", "error", "bad")
                talker.event("logged", "error")
                wait([stock, ours], timeout=0.05)  # a flood would leave them no time to start
        code, out, _ = stock.result()
        assert ours.result()[:2] == (code, out.replace("\x1b[1m", "").replace("\x1b[21m", "")) and code == 0


def test_rosgraph_l177(tools: Path, launcher: Master, talker: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same lines; ours are sorted within their block, and there at once: stock asks its nodes now and then."""
    monkeypatch.setitem(globals(), "LIMIT", 20.0)
    until(lambda: len(launcher.node("/misc_talker", "getBusInfo")[2]) > 0, "the talker is connected to rosout")
    stock, ours = both(tools, "rosgraph", launcher.environ())

    def blocks(text: str) -> list[list[str]]:
        return [sorted(block.split()) for block in text.split("\n\n\n")]

    assert ours[1].startswith("\n\nNodes:\n") and stock[1].startswith("\n\nNodes:\n")
    assert "/misc_talker" in blocks(ours[1])[0] and blocks(ours[1])[0] in blocks(stock[1])
    monkeypatch.undo()
    for command in ("rosgraph foo", "rosgraph -h", "rosgraph --help"):
        stock, ours = both(tools, command, launcher.environ())
        assert ours[:2] == stock[:2]
    nobody = {**launcher.environ(), "ROS_MASTER_URI": "http://localhost:1"}
    stock, ours = both(tools, "rosgraph", nobody)
    assert ours[:2] == stock[:2] and ours[2].startswith(f"{stock[2]}no answer from the master at http://localhost:1 (")
