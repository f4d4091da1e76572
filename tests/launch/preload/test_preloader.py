"""Python nodes as forks: they cannot tell that they were not started in the usual way, and end as all others.

Feature: faster start of many Python nodes -- `pyros1 launch --preload`: forks of a process that has already imported
    pyros1 and rospy
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.python_modules import modules_environment
from pyros1.launch.preload.preloader import ForkedProcess, Preloader, python_script
from pyros1.launch.preload.server import serve
from pyros1.launch.running.watchdog import group_exists

from ..running.test_fifty import left

SOURCE = Path(__file__).resolve().parents[3] / "src"
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
# In signal.pause() a program may sleep on: a signal that arrives just before it is handled only after it.
PAUSE = "import time\nwhile True:\n    time.sleep(0.01)\n"
SELF = """\
import atexit, json, os, pickle, random, signal, sys, threading

class Thing:
    pass

atexit.register(print, "at the end")
found = {
    "argv": sys.argv, "orig": sys.orig_argv[1:], "name": __name__, "file": __file__, "path": sys.path[:1],
    "folder": os.getcwd(), "mine": os.environ.get("MINE"), "leads": os.getsid(0) == os.getpid() == os.getpgrp(),
    "interrupt": signal.getsignal(signal.SIGINT) is signal.default_int_handler,
    "child": signal.getsignal(signal.SIGCHLD) == signal.SIG_DFL,
    "pipe": signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN,
    "threads": threading.active_count(), "main": threading.current_thread() is threading.main_thread(),
    "pickle": isinstance(pickle.loads(pickle.dumps(Thing())), Thing), "flags": list(sys.flags),
    "names": sorted(set(globals()) - {"__annotations__", "__cached__"}),
    "modules": sys.modules["__main__"].Thing is Thing,
    "descriptors": sorted(int(n) for n in os.listdir("/proc/self/fd") if os.path.exists("/proc/self/fd/" + n)),
    "outputs": [sys.stdout.encoding, sys.stdout.errors, sys.stdout.line_buffering, sys.stderr.line_buffering],
    "environ": sorted(os.environ), "python": sys.executable, "prefix": sys.prefix,
    "signals": [n for n in range(1, 32) if n in signal.pthread_sigmask(signal.SIG_BLOCK, [])],
}
print(json.dumps(found))
print("to stderr", file=sys.stderr)
"""


@pytest.fixture
def environ() -> dict[str, str]:
    return {**os.environ, "MINE": "so"}


@pytest.fixture
def preloader(environ: dict[str, str]) -> Iterator[Preloader]:
    made = Preloader(environ)
    yield made
    made.close()


@pytest.fixture
def script(tmp_path: Path) -> Callable[[str], str]:
    def write(text: str) -> str:
        file = tmp_path / "node"
        file.write_text(f"#!{sys.executable}\n{text}")
        file.chmod(0o755)
        return str(file)

    return write


class Run:
    """A program that was run to its end."""

    def __init__(self, code: int, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


def begin(
    preloader: Preloader, words: list[str], environ: dict[str, str], folder: Path
) -> tuple[ForkedProcess, Path, Path]:
    out, err = folder / "out", folder / "err"
    with out.open("wb") as first, err.open("wb") as second:
        forked = preloader.start(words, environ, str(folder), first.fileno(), second.fileno())
    assert forked is not None
    forked.begin()
    return forked, out, err


def run(preloader: Preloader, words: list[str], environ: dict[str, str], folder: Path) -> Run:
    forked, out, err = begin(preloader, words, environ, folder)
    return Run(forked.wait(), out.read_text(), err.read_text())


def usual(words: list[str], environ: dict[str, str], folder: Path) -> Run:
    with (folder / "out").open("w+") as out, (folder / "err").open("w+") as err:
        code = subprocess.run(
            words, env=environ, cwd=folder, stdout=out, stderr=err, start_new_session=True, timeout=60, check=False
        ).returncode
        return Run(code, (folder / "out").read_text(), (folder / "err").read_text())


@pytest.mark.slow
def test_a_program_sees_what_it_sees_in_the_usual_way(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    link = tmp_path / "links" / "talker"
    link.parent.mkdir()
    link.symlink_to(script(SELF))
    for words in ([str(link), "a", "", "x:=1 2"], [sys.executable, script(SELF), "--flag"]):
        here, there = run(preloader, words, environ, tmp_path), usual(words, environ, tmp_path)
        ours, stock = (json.loads(each.out.splitlines()[0]) for each in (here, there))
        assert ours == stock
        assert (here.code, here.err, here.out.splitlines()[1:]) == (there.code, there.err, there.out.splitlines()[1:])
        assert here.out.splitlines()[1] == "at the end"


@pytest.mark.slow
@pytest.mark.parametrize(
    "end",
    [
        "",
        "sys.exit(3)",
        "sys.exit('with a text')",
        "sys.exit()",
        "def f():\n    1 / 0\nf()",
        "raise KeyboardInterrupt",
        "os._exit(7)",
        "os.kill(os.getpid(), 9)",
        "os.abort()",
        "def f(:",
        "import threading; threading.Thread(target=lambda: (time.sleep(0.1), print('later'))).start()",
        "sys.excepthook = lambda *_: print('mine'); 1 / 0",
        "print('\\N{SNOWMAN}'); print(repr('\\udc80'), file=sys.stderr)",
        "import missing_for_sure",
        "import Queue",
    ],
)
def test_ends(preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path, end: str) -> None:
    """The same exit code, output and traceback."""
    words = [script(f"import os, sys, time\nprint('begins')\n{end}\n")]
    here, there = run(preloader, words, environ, tmp_path), usual(words, environ, tmp_path)
    assert (here.code, here.out, here.err) == (there.code, there.out, there.err)


def test_programs_have_random_numbers_of_their_own(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    words = [script("import random, uuid\nprint(random.random(), uuid.uuid4())\n")]
    assert len({run(preloader, words, environ, tmp_path).out for _ in range(5)}) == 5


def test_a_node_of_rospy(
    preloader: Preloader, script: Any, environ: dict[str, str], master: Any, tmp_path: Path
) -> None:
    environ |= {"ROS_MASTER_URI": master.uri, "ROS_NAMESPACE": "/here", "ROS_HOME": str(tmp_path / "ros")}
    environ |= modules_environment(environ)
    text = (
        "import rospy\nfrom std_msgs.msg import Float64\nrospy.init_node('talker')\n"
        "rospy.Publisher('t', Float64, queue_size=1).publish(1.0)\nprint(rospy.get_name(), rospy.resolve_name('x'))\n"
    )
    done = run(preloader, [script(text), "__name:=other", "x:=y"], environ, tmp_path)
    assert (done.code, done.out) == (0, "/here/other /here/y\n"), done.err


def begin_talking(
    preloader: Preloader, words: list[str], environ: dict[str, str], folder: Path
) -> tuple[ForkedProcess, str]:
    """Begin a program, and wait for its first line."""
    reader, writer = os.pipe()
    forked = preloader.start(words, environ, str(folder), writer, writer)
    os.close(writer)
    assert forked is not None
    forked.begin()
    with os.fdopen(reader) as said:
        return forked, said.readline()


def test_signals(preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path) -> None:
    words = [script(f"print('begins', flush=True)\n{PAUSE}")]
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        forked, said = begin_talking(preloader, words, environ, tmp_path)
        assert said == "begins\n"
        forked.send_signal(number)
        assert forked.wait() == -number
        forked.send_signal(number)  # nobody is there


@pytest.mark.slow
def test_many_at_once(preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path) -> None:
    words = script("import sys\nsys.exit(int(sys.argv[1]))\n")
    begun = [begin(preloader, [words, str(number)], environ, tmp_path)[0] for number in range(40)]
    assert [forked.wait() for forked in begun] == list(range(40))


def test_a_server_that_is_killed(preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path) -> None:
    """Its programs run on, their ends are noticed, and others are started in the usual way."""
    first = [script("import os, signal\nprint(os.getppid(), flush=True)\nsignal.pause()\n")]
    forked, said = begin_talking(preloader, first, environ, tmp_path)
    os.kill(int(said), signal.SIGKILL)
    for _ in range(1000):  # the first ones may still reach it
        again = preloader.start(first, environ, str(tmp_path), 1, 2)
        if again is None:
            break
        again.send_signal(signal.SIGKILL)
    assert again is None
    forked.send_signal(signal.SIGKILL)
    assert forked.wait() == -signal.SIGKILL


def test_a_zombie_has_ended() -> None:
    """Where process 1 waits for nobody, as in many containers, programs of a killed server stay as zombies."""
    ours, theirs = socket.socketpair()
    theirs.close()
    with subprocess.Popen(["true"]) as child:
        assert ForkedProcess(child.pid, ours).wait() == -signal.SIGKILL


def test_a_server_that_ends_hears_no_more_signals() -> None:
    """Else a program that ends just then lets Python write an error about the closed socket to the terminal."""
    ours, theirs = socket.socketpair()
    ours.close()
    before = signal.getsignal(signal.SIGCHLD)
    try:
        with theirs:
            assert serve(theirs) is None
        assert signal.set_wakeup_fd(-1) == -1
    finally:
        signal.signal(signal.SIGCHLD, before)


def test_what_cannot_be_forked(preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path) -> None:
    other = tmp_path / "other"
    for first in (b"#!/bin/sh\n", b"#!/usr/bin/python9\n", b"\x7fELF", b"", b"#!/usr/bin/env -S python3 -u\n", b"#!\n"):
        other.write_bytes(first + b"pass\n")
        assert python_script([str(other)], environ) is None
    good = script("")
    assert python_script([good], environ) == python_script([sys.executable, good], environ) == good
    for words in (["gdb", good], [sys.executable, "-u", good], [sys.executable], [str(tmp_path / "missing")]):
        assert python_script(words, environ) is None
    other.write_text("#!/usr/bin/env python3\n")
    assert python_script([str(other)], {"PATH": os.path.dirname(sys.executable)}) == str(other)
    assert python_script([str(other)], {"PATH": str(tmp_path)}) is None
    assert preloader.start([good], environ, str(tmp_path / "no folder"), 1, 2) is None


def test_another_interpreter_is_not_this_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One of another virtual environment finds other packages, though it is a link to the same file."""
    (tmp_path / "python3").symlink_to(sys.executable)
    (tmp_path / "python9").write_text("#!/bin/sh\n")
    for name in ("python3", "python9"):
        (tmp_path / f"{name}-node").write_text(f"#!{tmp_path / name}\n")
    words = [[str(tmp_path / f"{name}-node")] for name in ("python3", "python9")]
    assert [python_script(each, {}) for each in words] == [None, None]
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python3"))
    assert [python_script(each, {}) for each in words] == [words[0][0], None]


@pytest.mark.slow
def test_other_settings_of_python_get_another_server(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    words = [script("import sys, os\nprint(sys.flags.optimize, os.getppid())\n")]
    first = run(preloader, words, environ, tmp_path).out.split()
    second = run(preloader, words, {**environ, "PYTHONOPTIMIZE": "1"}, tmp_path).out.split()
    third = run(preloader, words, {**environ, "OTHER": "1"}, tmp_path).out.split()
    assert [first[0], second[0]] == ["0", "1"]
    assert first[1] == third[1] != second[1]


@pytest.mark.slow
def test_a_signal_reaches_a_program_that_was_just_forked(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    """It leads its group as soon as it is known, also before its script runs."""
    words = [script(PAUSE)]
    for _ in range(20):
        forked, _, _ = begin(preloader, words, environ, tmp_path)
        os.killpg(forked.pid, signal.SIGINT)
        assert forked.wait() == -signal.SIGINT


def test_a_program_that_was_given_up_does_not_run(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If a server answers too late, the launcher has started the node in the usual way: there must not be two."""
    server = int(run(preloader, [script("import os\nprint(os.getppid())\n")], environ, tmp_path).out)
    words = [script("print('ran')\n")]
    reader, writer = os.pipe()
    os.kill(server, signal.SIGSTOP)
    try:
        with monkeypatch.context() as patched:
            patched.setattr("pyros1.launch.preload.preloader.REPLY_TIMEOUT", 0.01)
            assert preloader.start(words, environ, str(tmp_path), writer, writer) is None
    finally:
        os.kill(server, signal.SIGCONT)
        os.close(writer)
    assert run(preloader, words, environ, tmp_path).out == "ran\n"
    with os.fdopen(reader) as late:
        assert late.read() == ""


def test_a_server_without_room_lives_on(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    """It says so, tells how its programs end, and forks others once it can."""
    resource = pytest.importorskip("resource")
    sleeper = [script("import os, signal\nprint(os.getppid(), flush=True)\nsignal.pause()\n")]
    forked, said = begin_talking(preloader, sleeper, environ, tmp_path)
    server = int(said)
    others = [str(tmp_path / "other")]
    Path(others[0]).write_text(f"#!{sys.executable}\nimport os\nprint(os.getppid())\n")
    _, most = resource.prlimit(server, resource.RLIMIT_NOFILE)
    for files in range(4, 12):
        resource.prlimit(server, resource.RLIMIT_NOFILE, (files, most))
        ended = preloader.start(others, environ, str(tmp_path), 1, 2)
        if ended is not None:
            ended.begin()
            assert ended.wait() in (0, 1)
    resource.prlimit(server, resource.RLIMIT_NOFILE, (256, most))
    assert run(preloader, others, environ, tmp_path).out == f"{server}\n"
    forked.send_signal(signal.SIGTERM)
    assert forked.wait() == -signal.SIGTERM


def test_modules_are_not_those_of_the_folder_of_the_launcher(
    script: Any, environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    for name in ("select", "json", "rospy", "std_msgs"):
        (tmp_path / "elsewhere" / f"{name}.py").write_text(f"print('the wrong {name}')\n")
    monkeypatch.chdir(tmp_path / "elsewhere")
    made = Preloader(environ)
    words = [script("import json, sys\nprint('wrong' in json.__file__, sys.path)\n")]
    for more in ({}, {"PYTHONSAFEPATH": "1"}):
        wanted = usual(words, {**environ, **more}, tmp_path).out
        assert run(made, words, {**environ, **more}, tmp_path).out == wanted
    made.close()


def test_a_launcher_without_standard_output_forks_nothing(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its servers would have none either, and their programs no sys.stdout although they have a file for it."""
    monkeypatch.setattr(sys, "__stdout__", None)
    assert preloader.start([script("")], environ, str(tmp_path), 1, 2) is None


NODE = "import os, rospy\nrospy.init_node('x')\nos.write(1, b'up\\n')  # in one piece\nrospy.spin()\n"


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left_of_a_launch(
    script: Any, environ: dict[str, str], tmp_path: Path, free_port: int, number: int
) -> None:
    """Nodes and servers end with Ctrl-C, and when the launcher is killed; a node that dies is started again."""
    script(NODE)
    (tmp_path / "package.xml").write_text(
        '<package format="2"><name>nodes</name><version>1.0.0</version><description>n</description>'
        '<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>'
    )
    nodes = "".join(f'<node pkg="nodes" type="node" name="n{each}" output="screen"/>' for each in range(4))
    nodes += '<node pkg="nodes" type="node" name="again" output="screen" respawn="true"/>'
    (tmp_path / "all.launch").write_text(f"<launch>{nodes}</launch>")
    environ |= {
        "PYTHONPATH": str(SOURCE),
        "ROS_HOME": str(tmp_path / "ros"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port}",
        "ROS_PACKAGE_PATH": str(tmp_path),
        "PYROS1_TEST_MARK": str(tmp_path),
    }
    words = [sys.executable, "-m", "pyros1", "launch", "--preload", "--sigint-timeout=5", "all.launch"]
    with subprocess.Popen(
        words, cwd=tmp_path, env=environ, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as launcher:
        assert launcher.stdout is not None
        text, pid = "", 0
        while text.count("up\n") < 6:
            line = launcher.stdout.readline()
            assert line, text
            text += line
            if not pid and text.count("up\n") == 5:
                pid = int(text.partition("process[again-")[2].partition("pid [")[2].partition("]")[0])
                os.kill(pid, signal.SIGKILL)
        assert "[again-" in text and "exit code -9" in text, text
        launcher.send_signal(number)
        launcher.communicate(timeout=60)  # all of them have its standard output: until the last one has ended
    # The watchdog, which ended them if the launcher was killed, is about to end.
    assert [each for each in left(f"PYROS1_TEST_MARK={tmp_path}") if "watchdog.py" not in each] == []


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_program_does_not_run_if_its_launcher_is_killed_before_it_is_known(
    preloader: Preloader, script: Any, environ: dict[str, str], tmp_path: Path
) -> None:
    """The watchdog would not find it."""
    ran = tmp_path / "ran"
    words = [script(f"open({str(ran)!r}, 'w').close()\n")]
    forked = preloader.start(words, environ, str(tmp_path), 1, 2)
    assert forked is not None
    pid = forked.pid
    del forked  # and with it its link, as when the launcher is killed
    deadline = time.monotonic() + 20
    while group_exists(pid):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert not ran.exists()
