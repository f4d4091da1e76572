"""Processes of the interop tests: masters, peers and command-line tools, always with deadlines, always cleaned up."""

from __future__ import annotations

import atexit
import contextlib
import functools
import importlib.util
import json
import os
import re
import selectors
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

PEERS = Path(__file__).resolve().parent
INTEROP = PEERS.parent
ROOT = INTEROP.parent
SOURCE = ROOT / "src"
ROSCPP_PEER = INTEROP / "build" / "roscpp_peer"
STOCK_PYTHON = "/usr/bin/python3"
DEADLINE = 30.0  # seconds; every wait without a deadline of its own


_spec = importlib.util.spec_from_file_location("free_ports", ROOT / "tests" / "free_ports.py")
assert _spec is not None
assert _spec.loader is not None
_free_ports = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_free_ports)
free_port: Callable[[], int] = _free_ports.free_port


def missing_stock() -> str | None:
    """What is not there of stock ROS, or None when the tests can run."""
    tools = [tool for tool in ("rosmaster", "rostopic", "rosnode", "rosservice", "roslaunch") if not shutil.which(tool)]
    if tools:
        return f"stock ROS is not installed ({', '.join(tools)} not found); run interop/setup as root"
    if not ROSCPP_PEER.exists():
        return f"{ROSCPP_PEER} is not built; run interop/setup"
    return None


def until(reached: Callable[[], Any], what: str, timeout: float = DEADLINE) -> Any:
    """Ask again and again until *reached* returns something true, and return that; fail after *timeout* seconds."""
    end = time.monotonic() + timeout
    while True:
        value = reached()
        if value:
            return value
        assert time.monotonic() < end, f"not within {timeout} s: {what}"
        time.sleep(0.02)


_THREAD_ERROR = re.compile(r"^Exception in thread .*\n(?:Traceback .*\n(?: .*\n)*(?:\w.*\n)?(?:\n.*\n\n)?)+", re.M)


def without_thread_errors(stderr: str) -> str:
    """What a stock tool printed on stderr, without the tracebacks of its threads.

    On a busy machine, a stock tool that is about to exit may print them: e.g. its server still waits for connections.
    """
    return _THREAD_ERROR.sub("", stderr)


def _descendants(pid: int) -> list[int]:
    """The children of a process, their children and so on."""
    children: dict[int, list[int]] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError):
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(folder.name))
    found = [pid]
    for one in found:
        found.extend(children.get(one, []))
    return found[1:]


def stacks(pid: int) -> str:
    """What the threads of a Python process are at, if py-spy is here and may look."""
    spy = Path(sys.executable).with_name("py-spy")
    if not spy.exists():
        return ""
    said = subprocess.run([spy, "dump", "--pid", str(pid)], capture_output=True, text=True, timeout=30, check=False)
    return said.stdout or said.stderr


class Process:
    """A child process whose output is collected line by line, stdout and stderr together.

    They are two pipes, so that a line of the log does not come in the middle of what another thread prints: when output
    is unbuffered, Python writes each argument of ``print`` by itself.

    Args:
        command: program and arguments.
        environ: the whole environment.
        label: name in failure messages.
    """

    def __init__(self, command: Sequence[str], environ: Mapping[str, str], label: str = "") -> None:
        self.label = label or Path(command[0]).name
        self.lines: list[str] = []
        self._unread: deque[str] = deque()
        self._changed = threading.Condition()
        self._ended = False
        self.child = subprocess.Popen(
            list(command),
            env=dict(environ),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,  # its own process group, which teardown kills as one
        )
        self._reader = threading.Thread(target=self._read, name=f"output of {self.label}", daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        return self.child.pid

    def _read(self) -> None:
        with selectors.DefaultSelector() as selector:
            rests: dict[int, bytes] = {}
            for stream in (self.child.stdout, self.child.stderr):
                assert stream is not None
                selector.register(stream, selectors.EVENT_READ)
                rests[stream.fileno()] = b""
            while selector.get_map():
                for key, _ in selector.select():
                    data = os.read(key.fd, 1 << 16)
                    *lines, rests[key.fd] = (rests[key.fd] + data).split(b"\n")
                    if not data:
                        selector.unregister(key.fileobj)
                        lines = [rests[key.fd]] if rests[key.fd] else []
                    self._add([line.decode("utf-8", "replace") for line in lines])
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _add(self, lines: list[str]) -> None:
        with self._changed:
            self.lines += lines
            self._unread += lines
            self._changed.notify_all()

    def wait_line(self, pattern: str, timeout: float = DEADLINE) -> re.Match[str]:
        """The first line not yet taken in which the regular expression occurs; it is taken out of the unread ones."""
        wanted = re.compile(pattern)
        end = time.monotonic() + timeout
        with self._changed:
            while True:
                for line in self._unread:
                    match = wanted.search(line)
                    if match:
                        self._unread.remove(line)
                        return match
                left = end - time.monotonic()
                why = "ended" if self._ended else f"{timeout} s passed"
                assert left > 0 and not self._ended, f"{self.label}: {why} without {pattern!r}\n{self.transcript()}"
                self._changed.wait(left)

    def unread(self, pattern: str) -> list[str]:
        """The lines not yet taken in which the regular expression occurs; they stay."""
        wanted = re.compile(pattern)
        with self._changed:
            return [line for line in self._unread if wanted.search(line)]

    def transcript(self) -> str:
        """The last lines that it printed, for failure messages."""
        return "".join(f"  | {line}\n" for line in self.lines[-40:])

    def write(self, line: str) -> None:
        """Send one line to its standard input."""
        assert self.child.stdin is not None
        try:
            self.child.stdin.write(line.encode() + b"\n")
            self.child.stdin.flush()
        except BrokenPipeError:
            raise AssertionError(f"{self.label} ended before {line!r}\n{self.transcript()}") from None

    def signal(self, number: int) -> None:
        """Send a signal to the whole process group."""
        if self.child.poll() is None:
            os.killpg(self.child.pid, number)

    def wait(self, timeout: float = DEADLINE) -> int:
        """Wait for the end and return the exit code (negative: the signal)."""
        try:
            code = self.child.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(
                f"{self.label} did not end within {timeout} s\n{self.transcript()}{stacks(self.pid)}"
            ) from None
        self._reader.join(timeout)
        return code

    def close(self) -> None:
        """End the process if it still runs, in the end by SIGKILL, and release everything."""
        # A launcher puts its nodes into sessions of their own: should it be killed, they would live on with our pipe.
        offspring: set[int] = set()
        for number, patience in ((signal.SIGINT, 4.0), (signal.SIGKILL, 5.0)):
            if self.child.poll() is None:
                offspring.update(_descendants(self.child.pid))
            self.signal(number)
            try:
                self.child.wait(patience)
                break
            except subprocess.TimeoutExpired:
                continue
        self._kill_group()
        for pid in offspring:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self._reader.join(5.0)
        # A stream that another thread reads stays open: it would read another file with the same number.
        read = () if self._reader.is_alive() else (self.child.stdout, self.child.stderr)
        for stream in (self.child.stdin, *read):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):  # unsent input of a process that is gone
                    stream.close()

    def _kill_group(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.child.pid, signal.SIGKILL)  # children that outlived their parent


class Peer(Process):
    """A peer program: commands go in, event lines come out (see interop/README.md)."""

    kind: str
    name: str

    def tell(self, *words: object) -> None:
        """Send a command without waiting for its event."""
        self.write(" ".join(str(word) for word in words))

    def ask(self, *words: object, event: str | None = None, timeout: float = DEADLINE) -> str:
        """Send a command and return what follows in its event line.

        Args:
            words: the command.
            event: the words that the awaited line starts with.
        """
        self.tell(*words)
        return self.event(*(event or " ".join(str(word) for word in words)).split(), timeout=timeout)

    def event(self, *words: str, timeout: float = DEADLINE) -> str:
        """The rest of the first unread event line that starts with *words*; a failed command fails the test."""
        start = re.escape(" ".join(words))
        match = self.wait_line(rf"^(?:{start}(?: (?P<rest>.*))?|(?P<bad>error .*|timeout .*))$", timeout)
        assert not match["bad"], f"{self.label}: {match['bad']}"
        return match["rest"] or ""

    # the commands as methods, in the words of ROS

    def advertise(self, topic: str, type_name: str, queue_size: int = 100, latch: bool = False) -> None:
        self.ask("pub", topic, type_name, queue_size, int(latch), event=f"advertised {topic}")

    def publish(self, topic: str, seed: int = 1) -> str:
        """Publish the sample message of the topic's type; returns the serialized message as the sender printed it."""
        return self.ask("send", topic, seed, event=f"sent {topic}")

    def subscribe(self, topic: str, type_name: str, queue_size: int = 100) -> None:
        self.ask("sub", topic, type_name, queue_size, event=f"subscribed {topic}")

    def received(self, topic: str, timeout: float = DEADLINE) -> str:
        """The next message on *topic*, serialized."""
        return self.event("got", topic, timeout=timeout)

    def linked(self, topic: str, count: int = 1) -> None:
        """Wait until the publisher or subscriber of *topic* has exactly *count* connections."""
        self.ask("linked", topic, count)

    def header(self, topic: str) -> dict[str, str]:
        """Connection header of the last message received on *topic*; the definition is a checksum."""
        return dict(field.split("=", 1) for field in self.ask("header", topic).split())

    def serve(self, name: str, type_name: str, mode: str = "answer") -> None:
        self.ask("serve", name, type_name, mode, event=f"serving {name}")

    def available(self, name: str) -> None:
        self.ask("available", name)

    def call(self, name: str, type_name: str, seed: int = 1, persistent: bool = False) -> tuple[str, str]:
        """Call a service that answers: the request and the response, serialized, as the caller saw them."""
        self.tell("call", name, type_name, seed, int(persistent))
        return self.event("called", name), self.event("answer", name)

    def call_failing(self, name: str, type_name: str, seed: int = 1, persistent: bool = False) -> str:
        """Call a service that fails: the error as the caller saw it."""
        self.tell("call", name, type_name, seed, int(persistent))
        self.event("called", name)
        return self.event("failed", name)

    def quit(self) -> int:
        """End the program the ordinary way; returns the exit code."""
        self.write("quit")
        return self.wait()


class ForkedTools:
    """Command-line tools written in Python, started quickly: see ``forked_tools.py``.

    Args:
        python: path of the interpreter.
        modules: what to import once.
        folder: where programs are that are given by their names.
    """

    def __init__(self, python: str, modules: Sequence[str], folder: Path) -> None:
        self._folder = folder
        self._asking = threading.Lock()
        self._server = subprocess.Popen(
            [python, str(PEERS / "forked_tools.py"), *modules],
            env={"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "ROS_HOSTNAME": "localhost", "PYTHONPATH": str(SOURCE)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(
        self,
        words: Sequence[str],
        environ: Mapping[str, str],
        *,
        cwd: str | os.PathLike[str] = "/",
        stdin: str = "",
        timeout: float = 30,
    ) -> tuple[int, str, str]:
        """Run a tool to its end; returns exit code (negative for a signal), stdout and stderr.

        Args:
            words: the program, the name or path of a Python script, and its arguments.
            environ: the whole environment of the program.
            timeout: seconds after which SIGALRM ends it.
        """
        question = {
            "words": [str(self._folder / words[0]), *words[1:]],
            "cwd": str(cwd),
            "env": dict(environ),
            "stdin": stdin,
            "timeout": round(timeout),
        }
        with self._asking:
            assert self._server.stdin is not None and self._server.stdout is not None
            print(json.dumps(question), file=self._server.stdin, flush=True)
            line = self._server.stdout.readline()
        assert line, f"no answer to {words}"
        answer = json.loads(line)
        return answer["code"], answer["out"], answer["err"]

    def close(self) -> None:
        """End it."""
        assert self._server.stdin is not None and self._server.stdout is not None
        self._server.stdin.close()
        self._server.wait(DEADLINE)
        self._server.stdout.close()


@functools.cache
def stock_tools() -> ForkedTools:
    """Stock's tools; they end with this process."""
    modules = ("rostopic", "rosnode", "rosservice", "rosparam", "rosmsg", "rosgraph", "rosbag")
    tools = ForkedTools(STOCK_PYTHON, modules, Path("/usr/bin"))
    atexit.register(tools.close)
    return tools


@functools.cache
def stock_roslaunch() -> ForkedTools:
    """Stock's roslaunch; apart, since rosparam teaches the YAML library of its process about angles."""
    tools = ForkedTools(STOCK_PYTHON, ("roslaunch",), Path("/usr/bin"))
    atexit.register(tools.close)
    return tools


@functools.cache
def our_tools() -> ForkedTools:
    """Our commands under stock's names; they end with this process."""
    modules = [
        "main",
        "commands.topic.echo",
        "commands.topic.list",
        "commands.topic.pub",
        "commands.node.info",
        "commands.service.call",
        "commands.param.load",
        "commands.msg.show",
        "commands.launch",
        "commands.launch._queries",
    ]
    folder = tempfile.TemporaryDirectory(prefix="pyros1-tools-")
    for name in ("rostopic", "rosnode", "rosservice", "rosparam", "rosmsg", "rossrv", "rosmsg-proto", "roslaunch"):
        write_tool(Path(folder.name), name)
    tools = ForkedTools(sys.executable, [f"pyros1.cli.{name}" for name in modules], Path(folder.name))
    atexit.register(folder.cleanup)
    atexit.register(tools.close)
    return tools


def write_tool(folder: Path, name: str) -> Path:
    """Write a program that is ours under the name of a stock tool, so that usage texts too can be compared."""
    tool = folder / name
    start = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); from pyros1.cli.main import entry; sys.exit(entry())"
    tool.write_text(f"#!{sys.executable}\n{start}\n")
    tool.chmod(0o755)
    return tool


def child_environ(home: Path, uri: str | None, python: str, extra: Mapping[str, str | None]) -> dict[str, str]:
    """The environment of a child: nothing of the developer's ROS set-up, everything below *home*.

    Args:
        home: folder for logs, pid files and caches.
        uri: the master's.
        python: ``ours`` for programs that import pyros1.
        extra: more variables; None takes one away.
    """
    out = {
        "PATH": "/usr/local/bin:/usr/bin:/bin",
        "HOME": str(home),
        "LANG": "C.UTF-8",
        "PYTHONUNBUFFERED": "1",
        "ROS_MASTER_URI": uri,
        "ROS_HOSTNAME": "localhost",
        "ROS_HOME": str(home),
        "ROS_LOG_DIR": str(home / "log"),
    }
    if python == "ours":
        out["PATH"] = f"{Path(sys.executable).parent}:{out['PATH']}"
        if not _installed():
            out["PYTHONPATH"] = str(SOURCE)
    return {key: value for key, value in {**out, **extra}.items() if value is not None}


def peer_command(kind: str) -> list[str]:
    """The program of a peer: ``pyros1``, ``rospy`` or ``roscpp``."""
    return {
        "pyros1": [sys.executable, str(PEERS / "pyros1_peer.py")],
        "rospy": [STOCK_PYTHON, str(PEERS / "rospy_peer.py")],
        "roscpp": [str(ROSCPP_PEER)],
    }[kind]


class Master:
    """Address and processes of a running ROS master with its rosout node, and what to start against it.

    Args:
        kind: ``ours`` or ``stock``.
        home: folder for logs, pid files and caches.
        port: TCP port of the master.
    """

    def __init__(self, kind: str, home: Path, port: int) -> None:
        self.kind = kind
        self.home = home
        self.port = port
        self.uri = f"http://localhost:{port}/"
        self.core: list[Process] = []  # the master itself, and rosout
        self.processes: list[Process] = []
        self._shared: dict[str, Peer] = {}
        home.mkdir(parents=True, exist_ok=True)

    def environ(self, python: str = "stock", **extra: str | None) -> dict[str, str]:
        """The environment of a child: nothing of the developer's ROS set-up, everything below ``home``.

        Args:
            python: ``ours`` for programs that import pyros1.
            extra: more variables; None takes one away.
        """
        return child_environ(self.home, self.uri, python, extra)

    def start(self) -> None:
        """Start the master and rosout, and wait until both answer."""
        if self.kind == "ours":
            command = [sys.executable, "-m", "pyros1", "core", "-p", str(self.port)]
        else:
            command = ["rosmaster", "--core", "-p", str(self.port)]
        self.core.append(Process(command, self.environ(self.kind), f"{self.kind} master"))
        self.await_up()
        if self.kind == "stock":
            self.core.append(Process(["/usr/lib/rosout/rosout"], self.environ(), "rosout"))
        until(lambda: self.publishers("/rosout_agg"), f"rosout under the {self.kind} master")

    def stop(self) -> None:
        """End the master and rosout, and nothing else; `start` starts them again on the same port."""
        for process in reversed(self.core):
            process.close()
        self.core.clear()

    def await_up(self) -> None:
        """Wait until the master answers."""

        def answers() -> bool:
            try:
                return bool(self.call("getPid")[0] == 1)
            except OSError:
                assert self.core[0].child.poll() is None, f"the master ended\n{self.core[0].transcript()}"
                return False

        until(answers, f"the {self.kind} master answers", timeout=30)

    def call(self, method: str, *arguments: Any) -> list[Any]:
        """One call to the master's API as the node ``/harness``; returns code, message, value."""
        with xmlrpc.client.ServerProxy(self.uri) as proxy:
            return list(getattr(proxy, method)("/harness", *arguments))  # type: ignore[call-overload]  # dynamic proxy

    def node(self, name: str, method: str, *arguments: Any) -> list[Any]:
        """One call to a node's API."""
        with xmlrpc.client.ServerProxy(self.call("lookupNode", name)[2]) as proxy:
            return list(getattr(proxy, method)("/harness", *arguments))  # type: ignore[call-overload]  # dynamic proxy

    def publishers(self, topic: str) -> list[str]:
        """Names of the nodes that are registered as publishers of *topic*."""
        return dict(self.call("getSystemState")[2][0]).get(topic, [])

    def subscribers(self, topic: str) -> list[str]:
        """Names of the nodes that are registered as subscribers of *topic*."""
        return dict(self.call("getSystemState")[2][1]).get(topic, [])

    def sends(self, topic: str) -> None:
        """Wait until each publisher of *topic* has a link for it; subscribers know of their link a little earlier."""
        for name in self.publishers(topic):
            until(
                lambda name=name: ["o", topic] in [[each[2], each[4]] for each in self.node(name, "getBusInfo")[2]],
                f"{name} sends {topic}",
            )

    def run(self, command: Sequence[str], *, python: str = "stock", label: str = "", **extra: str | None) -> Process:
        """Start a program that lives until teardown at most."""
        process = Process(command, self.environ(python, **extra), label)
        self.processes.append(process)
        return process

    def peer(self, kind: str, name: str, *arguments: str, **extra: str | None) -> Peer:
        """Start a peer program of its own, without waiting for it to be ready.

        Args:
            kind: ``pyros1``, ``rospy`` or ``roscpp``.
            name: node name.
            arguments: remappings.
            extra: more environment variables.
        """
        environ = self.environ("ours" if kind == "pyros1" else "stock", **extra)
        peer = Peer([*peer_command(kind), name, *arguments], environ, f"{kind} peer {name}")
        peer.kind, peer.name = kind, "/" + name
        self.processes.append(peer)
        return peer

    def ready_peer(self, kind: str, name: str, *arguments: str, **extra: str | None) -> Peer:
        """Start a peer program of its own and wait until its node is up."""
        peer = self.peer(kind, name, *arguments, **extra)
        peer.name = peer.event("ready", timeout=30)
        return peer

    def shared(self, role: str, kind: str) -> Peer:
        """The peer that all tests share, one for each *role* and *kind*; tests keep apart by their topic names."""
        peer = self._shared.get(role + kind)
        if peer is None or peer.child.poll() is not None:
            peer = self._shared[role + kind] = self.ready_peer(kind, f"{role}_{kind}_peer")
        return peer

    def tool(self, *command: str, code: int | None = 0, timeout: float = 30, stdin: str = "") -> str:
        """Run a stock command-line tool to its end; returns stdout and stderr, in this order.

        Args:
            command: for example ``rostopic``, ``list``.
            code: the expected exit code, None if it does not matter.
        """
        if command[0].startswith("ros"):
            ended, stdout, stderr = stock_tools().ask(command, self.environ(), stdin=stdin, timeout=timeout)
            out = stdout + stderr
        else:
            done = subprocess.run(
                command, env=self.environ(), input=stdin.encode(), capture_output=True, timeout=timeout, check=False
            )
            ended, out = done.returncode, (done.stdout + done.stderr).decode("utf-8", "replace")
        assert code is None or ended == code, f"{' '.join(command)}: exit code {ended}\n{out}"
        return out

    def close_since(self, mark: int) -> None:
        """End the processes that were started after *mark* of them ran, newest first."""
        shared = list(self._shared.values())
        for process in reversed(self.processes[mark:]):
            if process not in shared:
                process.close()
                self.processes.remove(process)

    def close(self) -> None:
        """End everything."""
        self._shared.clear()
        self.close_since(0)
        self.stop()


@functools.cache
def _installed() -> bool:
    """Whether the Python that runs the tests has the pyros1 installed that the tests import."""
    probe = "import importlib.util; spec = importlib.util.find_spec('pyros1'); print(spec and spec.origin)"
    said = subprocess.run(
        [sys.executable, "-I", "-c", probe], capture_output=True, text=True, check=True, timeout=30
    ).stdout
    spec = importlib.util.find_spec("pyros1")
    return spec is not None and said.strip() == spec.origin
