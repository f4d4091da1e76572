"""Other systems: modules are imported, nodes and commands run, where Python lacks what only Unix has, as on Windows.

Feature: nodes, core, launch, bags and tools do not need Unix-only features -- tested with them hidden; never tried on
    Windows itself: [systems](src/pyros1/guide/howto/systems.md)
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / "src"
DEADLINE = 60.0

HIDE = """
import asyncio, importlib, os, select, selectors, shutil, signal, socket, stat, subprocess, sys, tempfile

def socketpair():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return socket.create_connection(server.getsockname()), server.accept()[0]

class Select:  # an object, since selectors would make a method of a function
    def __call__(self, reading, writing, failing, timeout=None, select=select.select):
        for each in (*reading, *writing, *failing):
            if not stat.S_ISSOCK(os.fstat(each if isinstance(each, int) else each.fileno()).st_mode):
                raise OSError("only sockets can be waited for")
        return select(reading, writing, failing, timeout)

socket.socketpair = socketpair
select.select = Select()
for name in "fcntl termios tty pwd grp resource pty posix syslog curses readline".split():
    sys.modules[name] = None
LACKING = {
    os: "fork forkpty killpg getpgid setsid getuid geteuid getgid getpgrp setpgid tcgetpgrp wait3 wait4 openpty"
    " getloadavg mkfifo chown fchmod sysconf posix_fadvise sched_getaffinity set_blocking",
    signal: "SIGKILL SIGHUP SIGQUIT SIGALRM SIGCHLD SIGCONT SIGSTOP SIGUSR1 SIGUSR2 SIGTSTP SIGPIPE SIGWINCH setitimer"
    " pthread_sigmask alarm sigwait pthread_kill pause",
    select: " ".join(name for name in dir(select) if "poll" in name.lower()),
    socket: "AF_UNIX SO_REUSEPORT MSG_DONTWAIT TCP_KEEPIDLE TCP_USER_TIMEOUT",
}
for module, names in LACKING.items():
    for name in names.split():
        if hasattr(module, name):
            delattr(module, name)
importlib.reload(selectors)  # without what has just gone
"""

IMPORTS = """
import importlib, pathlib, sys
import pyros1

root = pathlib.Path(pyros1.__file__).parent
others = {"examples", "packages", "templates", "modules", "start", "vendor"}  # programs, and what has other names
for path in sorted(root.rglob("*.py")):
    parts = path.relative_to(root.parent).with_suffix("").parts
    if others.isdisjoint(parts) and parts[-1] not in ("__main__", "build_backend"):
        name = ".".join(parts).removesuffix(".__init__")
        try:
            importlib.import_module(name)
        except Exception as error:
            print(f"{name}: {type(error).__name__}: {error}")
print(len(sys.modules) > 500, sys.modules["fcntl"])
"""

NODE = """
import pyros1
from pyros1 import actions
from pyros1.tf import Buffer, TransformListener
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciGoal, FibonacciResult
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Trigger

with pyros1.Node("both") as node:
    print(node.wait_for_message("topic1", Float64, timeout=20).data > 0)
    node.advertise_service("ask", Trigger, lambda _: {"success": True, "message": "yes"})
    print(node.service("ask", Trigger)().message)
    node.params["~x"] = 3
    print(node.params.cached("~x"), node.sleep(0.01))
    TransformListener(node, Buffer()).close()
    watch = node.watch("minimal_publisher")
    execute = lambda goal: FibonacciResult(sequence=[goal.goal.order])
    with actions.SimpleServer(node, "fibonacci", FibonacciAction, execute):
        with actions.Client(node, "fibonacci", FibonacciAction) as client:
            print(client.send(FibonacciGoal(order=7)).result(timeout=20).sequence)
"""


@pytest.fixture
def env(tmp_path: Path, free_port: int) -> dict[str, str]:
    """The environment of programs that lack what only Unix has, with a master of their own."""
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / "sitecustomize.py").write_text(HIDE)
    return {
        **{name: value for name, value in os.environ.items() if not name.startswith("ROS")},
        "PYTHONPATH": f"{tmp_path / 'hidden'}{os.pathsep}{SOURCES}",
        "ROS_HOME": str(tmp_path / "ros"),
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_port}",
        "ROS_IP": "127.0.0.1",
    }


@pytest.fixture
def run(env: dict[str, str], tmp_path: Path) -> Callable[..., str]:
    """Return a function that runs Python, or with other first words a command, and returns what it prints."""

    def call(*words: str, code: int = 0) -> str:
        command = [sys.executable, *(words if words[0] == "-c" else ("-m", "pyros1", *words))]
        done = subprocess.run(
            command, cwd=tmp_path, env=env, stdin=subprocess.DEVNULL, capture_output=True, text=True,
            timeout=DEADLINE, check=False,
        )  # fmt: skip
        assert done.returncode == code and "Traceback" not in done.stderr, done.stdout + done.stderr
        return done.stdout + done.stderr

    return call


@pytest.fixture
def start(env: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., None]]:
    """Return a function that starts a command and waits for a line; Ctrl-C ends it, without a traceback."""
    running: list[subprocess.Popen[str]] = []

    def begin(line: str, *words: str) -> None:
        child = subprocess.Popen(
            [sys.executable, "-u", "-m", "pyros1", *words],
            cwd=tmp_path, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True,
        )  # fmt: skip
        running.append(child)
        assert child.stdout is not None
        said = []
        for each in child.stdout:
            said.append(each)
            if line in each:
                return
        pytest.fail(f"{words} ended: {''.join(said)}")

    yield begin
    for child in reversed(running):
        child.send_signal(signal.SIGINT)
        out, _ = child.communicate(timeout=DEADLINE)
        assert child.returncode == 0 and "Traceback" not in out, out


@pytest.mark.slow
def test_all_modules_are_imported_where_nothing_of_unix_is(run: Callable[..., str]) -> None:
    assert run("-c", IMPORTS) == "True None\n"


@pytest.mark.slow
@pytest.mark.once
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_nodes_and_commands_run_where_nothing_of_unix_is(
    run: Callable[..., str], start: Callable[..., None], tmp_path: Path, free_port: int
) -> None:
    start("started core service", "core", "-p", str(free_port))
    (tmp_path / "a.launch").write_text(
        '<launch><node pkg="minimal_nodes" type="minimal_publisher" name="minimal_publisher" output="screen"/>'
        '<node pkg="minimal_nodes" type="minimal_subscriber" name="minimal_subscriber" output="screen"/></launch>'
    )
    start("received value is", "launch", "a.launch")
    assert run("-c", NODE) == "True\nyes\n3 True\n(7,)\n"
    assert "/topic1\n" in run("topic", "list")
    assert re.match(r"data: \d", run("topic", "echo", "-n", "1", "/topic1"))
    assert "Publications" in run("node", "info", "/minimal_publisher")
    assert "3 messages" in run("bag", "record", "-O", "x", "-l", "3", "/topic1")
    assert re.search(r"messages: +3\n", run("bag", "info", "x.bag"))
    assert "Done." in run("bag", "play", "x.bag")
    assert "Online checks" in run("wtf")
    assert "minimal_publisher" in run("node", "status")
    assert "stopped" in run("node", "stop", "/minimal_subscriber")
    assert "type pyros1 before each command" in run("setup", code=1)
    start("Spawning turtle", "run", "turtlesim", "turtlesim_node")
    assert "x:" in run("topic", "echo", "-n", "1", "/turtle1/pose")
    start("in a browser: ", "web", "--port", "0")
