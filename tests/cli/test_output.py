"""Standard output that is full, closed, not read or of a narrow encoding; and Ctrl-C at any moment.

Feature: a full, closed or narrow standard output -- at most one line of error, and the right exit code
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.cli.commands.setup._programs import make_programs
from pyros1.cli.registry import stock_names
from pyros1.msgs.std_msgs.msg import Float64

SOURCE = Path(__file__).resolve().parents[2] / "src"
FULL = "ERROR: cannot write to standard output: No space left on device\n"
COMMANDS = [
    "topic list",
    "node tree",
    "topic echo /t",
    "topic hz /t",
    "help",
    "topic list -h",
    "run",
    "msg show std_msgs/Char",
    "graph",
]


@pytest.fixture
def system(make_node: Any, environ: dict[str, str]) -> Iterator[dict[str, str]]:
    """The environment of a process in a system with a topic, which has a message now and then."""
    node = make_node("talker")
    publisher = node.advertise("t", Float64, latch=True)
    publisher.publish(Float64(1.0))
    timer = node.timer(0.05, lambda event: publisher.publish(Float64(2.0)))
    yield {**os.environ, **environ, "PYTHONPATH": str(SOURCE), "PYTHONUNBUFFERED": ""}
    timer.shutdown()


def run(words: str, environ: dict[str, str], **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "pyros1", *words.split()], env=environ, stderr=subprocess.PIPE, encoding="utf-8",
        timeout=30, check=False, **options,
    )  # fmt: skip


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full")
@pytest.mark.parametrize("words", COMMANDS)
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_said_in_a_line(system: dict[str, str], words: str, unbuffered: str) -> None:
    with open("/dev/full", "w") as full:
        done = run(words, {**system, "PYTHONUNBUFFERED": unbuffered}, stdout=full)
    assert (done.returncode, done.stderr) == (1, FULL)


@pytest.mark.parametrize("words", COMMANDS)
def test_nobody_reads(system: dict[str, str], words: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = run(words, system, stdout=writing)
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("words", ["topic list", "node tree", "topic echo -n 1 /t", "help"])
def test_closed(system: dict[str, str], words: str) -> None:
    done = run(words, system, preexec_fn=lambda: os.close(1))
    assert (done.returncode, done.stderr) == (0, "")


def test_a_closed_descriptor_is_not_a_sockets(system: dict[str, str], tmp_path: Path) -> None:
    """What a command starts would write into whatever has the number."""
    package = tmp_path / "closed"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>closed</name></package>")
    show = package / "show"
    names = "[os.readlink(f'/proc/self/fd/{number}') for number in range(3)]"
    show.write_text(f"#!{sys.executable}\nimport os\nopen('{tmp_path}/seen', 'w').write(repr({names}))\n")
    show.chmod(0o755)
    run("run closed show", {**system, "ROS_PACKAGE_PATH": str(tmp_path)}, preexec_fn=lambda: os.closerange(0, 3))
    if not os.path.exists("/proc/self/fd"):
        pytest.skip("only Linux tells")
    assert (tmp_path / "seen").read_text() == repr(3 * ["/dev/null"])


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "utf-16", "utf-8", "ascii:strict", "utf-8:strict"])
@pytest.mark.parametrize("words", ["node tree", "param get /text"])
def test_encodings(system: dict[str, str], make_node: Any, encoding: str, words: str) -> None:
    make_node("setter").params["/text"] = "grün → 木"
    done = run(words, {**system, "PYTHONIOENCODING": encoding}, stdout=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (0, "")


def test_texts_of_messages_that_are_not_utf8_are_told_once(system: dict[str, str], tmp_path: Path) -> None:
    file = str(tmp_path / "old.bag")
    header = {
        "type": "std_msgs/String",
        "md5sum": "992ce8a1687cec8c8bd883ec73ca41d1",
        "message_definition": "string data",
    }
    with pyros1.bag.open(file, "w") as bag:
        for number in (1.0, 2.0):
            bag.write_raw("/t", b"\4\0\0\0ab\xe4c", header, number)
    done = run(f"topic echo -b {file} /t", system, stdout=subprocess.PIPE)
    assert (done.returncode, done.stdout) == (0, 2 * 'data: "ab\\uFFFDc"\n---\n')
    assert done.stderr == "WARNING: std_msgs/String: bytes in strings that are not UTF-8 are replaced\n"


def test_drawings_without_the_characters(system: dict[str, str]) -> None:
    environ = {**system, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    lines = run("node tree", environ, stdout=subprocess.PIPE).stdout.splitlines()
    assert lines[:2] == ["/", "`- talker"]


def test_file_names_that_are_no_text_pass(system: dict[str, str], tmp_path: Path) -> None:
    folder = os.fsencode(tmp_path) + b"/gr\xfcn"
    os.mkdir(folder)
    with open(folder + b"/package.xml", "w") as file:
        file.write("<package><name>green</name></package>")
    environ = {os.fsencode(name): os.fsencode(value) for name, value in system.items()}
    environ[b"ROS_PACKAGE_PATH"] = os.fsencode(tmp_path)
    for encoding in (b"ascii", b"utf-8", b"latin-1"):
        done = subprocess.run(
            [sys.executable, "-m", "pyros1", "pkg", "find", "green"], capture_output=True, timeout=30, check=False,
            env={**environ, b"PYTHONIOENCODING": encoding + b":surrogateescape"},
        )  # fmt: skip
        assert done.stdout == folder + b"\n", done.stderr


# Ctrl-C -------------------------------------------------------------------------------------------------------------

SHORT = ["pyros1 topic list", "rosnode list", "rosmsg show std_msgs/Char", "pyros1 wtf --offline"]
LASTING = ["rostopic echo /t", "pyros1 topic hz /t", "rosrun topic_tools relay /t", "rosrun turtlesim mimic"]
TIMES = [0.03, 0.06, 0.1, 0.15, 0.25]


def has_our_frames(trace: str) -> bool:
    lines = [line for line in trace.splitlines() if f"{SOURCE}/pyros1/" in line]
    first = ("/packages/", "pyros1/__init__.py", "pyros1/cli/__init__.py", "pyros1/cli/main.py")  # what is loaded first
    return any(not any(part in line for part in first) for line in lines)


@pytest.mark.slow
@pytest.mark.parametrize("words", [*SHORT, *LASTING])
def test_ctrl_c_at_any_moment(system: dict[str, str], tmp_path: Path, words: str) -> None:
    """Nothing is shown. What was cut short has died of the signal; what runs until Ctrl-C ends with 0 if it ran.

    Feature: Ctrl-C shows no traceback -- commands that run until Ctrl-C exit with 0; interrupted commands
        die of SIGINT (130 in a shell); signals within half a second count once
    """
    folder = make_programs(stock_names(), {"XDG_DATA_HOME": str(tmp_path)})
    program, *rest = words.split()
    command = [str(folder / program), *rest]
    for seconds in TIMES:
        child = subprocess.Popen(
            command, env=system, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        time.sleep(seconds)  # not to wait for anything: the moment is what is tested
        child.send_signal(signal.SIGINT)
        try:
            _, err = child.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            child.send_signal(signal.SIGINT)  # the interpreter's own start may swallow one
            _, err = child.communicate(timeout=20)
        is_of_start = "KeyboardInterrupt" in err or "Python runtime state: core initialized" in err
        if is_of_start and not has_our_frames(err):
            continue  # the interpreter's own start: nothing of ours was there yet
        assert "Traceback" not in err and "Exception" not in err, err
        assert child.returncode in (0, 130, -signal.SIGINT)


def test_a_command_that_is_cut_short_dies_of_the_signal(environ: dict[str, str], tmp_path: Path) -> None:
    """So a loop of the shell around it ends, too."""
    folder = make_programs(stock_names(), {"XDG_DATA_HOME": str(tmp_path)})
    child = subprocess.Popen(
        [folder / "pyros1", "param", "load", "-", "/x"], env={**os.environ, **environ}, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 20
    while "read" not in Path(f"/proc/{child.pid}/wchan").read_text() and time.monotonic() < deadline:
        time.sleep(0.01)
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=20)
    assert (child.returncode, out, err) == (-signal.SIGINT, "", "")


def test_an_interrupt_that_a_program_does_not_catch_is_shown_as_python_shows_it() -> None:
    program = "import pyros1, signal\nsignal.raise_signal(signal.SIGINT)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=20, check=False)
    assert done.stderr.endswith("KeyboardInterrupt\n") and "Traceback" in done.stderr
