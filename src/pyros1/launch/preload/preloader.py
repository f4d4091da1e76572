"""Starts Python nodes by forking processes that have already imported pyros1: ``pyros1 launch --preload``.

A node can be forked if the first line of its script names this launcher's interpreter, and the script is not run
through another program, such as a launch-prefix.

Nodes share a server if their environments have the same values of all variables that an interpreter, or the modules
imported by the server, read at startup (`SHARED_VARIABLE_PREFIXES`). A server is started together with its first node.
Its code is in `server`.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from pyros1.launch.preload.server import LENGTH_FORMAT, NUMBER_FORMAT

SHARED_VARIABLE_PREFIXES = (
    "PYTHON",
    "LD_",
    "MALLOC_",
    "LC_",
    "LANG",
    "PYROS1_ROSPY",
    "CMAKE_PREFIX_PATH",
    "ROS_PACKAGE_PATH",
    "PATH",
    "HOME",
)
"""Prefixes of the variables that must be the same in the environments of a server and its nodes."""
# The current folder is removed from sys.path: files there may have the names of Python's modules.
_START_CODE = (
    "import sys; '' in sys.path and sys.path.remove(''); from pyros1.launch.preload.server import main; exec(*main({}))"
)
REPLY_TIMEOUT = 30.0
"""Timeout in seconds for a server to start and to fork."""
_MAX_SHEBANG_LENGTH = 200


class ForkedProcess:
    """A process forked by a server. It does not run its program before `begin` is called.

    It has the methods of `subprocess.Popen` that a launcher needs.

    Args:
        pid: the process id.
        link: the socket over which the server reports the exit code.
    """

    def __init__(self, pid: int, link: socket.socket) -> None:
        self.pid = pid
        self._link = link

    def begin(self) -> None:
        """Let the forked process run its program. If the launcher is killed before this, the forked process exits."""
        with contextlib.suppress(OSError):  # the process was killed, which `wait` will report
            self._link.sendall(b"+")
        self._link.settimeout(None)

    def wait(self) -> int:
        """Wait until the process has exited; return its exit code, negative for a signal. May be called only once."""
        with self._link as link:
            data = b""
            with contextlib.suppress(OSError):
                data = link.recv(NUMBER_FORMAT.size)
        if len(data) == NUMBER_FORMAT.size:
            return int(NUMBER_FORMAT.unpack(data)[0])
        while _is_running(self.pid):  # the server was killed, so the launcher must poll
            time.sleep(0.1)
        return -signal.SIGKILL

    def send_signal(self, number: int) -> None:
        """Send a signal to the process, if it is running."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def terminate(self) -> None:
        """Send SIGTERM to the process."""
        self.send_signal(signal.SIGTERM)


def _is_running(pid: int) -> bool:
    """Return whether a process that is not our child is running. Zombies do not count: they may never be reaped."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # the process has changed its user
        pass
    try:
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[0] not in "ZX"
    except OSError:  # the system has no /proc, or the process has just exited, which the next check will find
        return True


class _Server:
    """A server process that forks nodes.

    Args:
        environ: the server's environment.
    """

    def __init__(self, environ: Mapping[str, str]) -> None:
        self._lock = threading.Lock()
        self._control, server_end = socket.socketpair()
        with server_end:
            descriptor = server_end.fileno()
            self._process = subprocess.Popen(
                [sys.executable, "-c", _START_CODE.format(descriptor)],
                env=dict(environ),
                pass_fds=[descriptor],
                start_new_session=True,
            )

    def fork(
        self, script: str, words: Sequence[str], environ: Mapping[str, str], folder: str, out: int, err: int
    ) -> ForkedProcess:
        """Fork a process, which waits for `ForkedProcess.begin`: if this method times out, the process does nothing.

        Raises:
            OSError: the server does not respond, or cannot fork.
        """
        request = {"script": script, "words": list(words), "environ": dict(environ), "folder": folder}
        text = json.dumps(request).encode()
        link, server_end = socket.socketpair()
        link.settimeout(REPLY_TIMEOUT)
        try:
            with server_end, self._lock:
                socket.send_fds(self._control, [b"+"], [server_end.fileno(), out, err])
            link.sendall(LENGTH_FORMAT.pack(len(text)) + text)
            data = link.recv(NUMBER_FORMAT.size)
            pid = NUMBER_FORMAT.unpack(data)[0] if len(data) == NUMBER_FORMAT.size else 0
            if pid <= 0:  # the process was killed immediately
                raise ConnectionError("the process that forks nodes has exited, or cannot fork")
        except BaseException:
            link.close()
            raise
        return ForkedProcess(pid, link)

    def close(self) -> None:
        """Stop the server."""
        self._control.close()
        try:
            self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class Preloader:
    """Starts Python nodes by forking.

    Args:
        environ: the launcher's environment. Servers inherit it, except for variables with `SHARED_VARIABLE_PREFIXES`,
            which they get from the environment of their nodes.
    """

    def __init__(self, environ: Mapping[str, str]) -> None:
        self._environ = dict(environ)
        self._servers: dict[tuple[tuple[str, str], ...], _Server] = {}

    def start(
        self, words: Sequence[str], environ: Mapping[str, str], folder: str, out: int, err: int
    ) -> ForkedProcess | None:
        """Start a process, which waits for `ForkedProcess.begin` before it runs a program.

        Args:
            words: the command line.
            environ: the complete environment.
            folder: the working directory.
            out, err: descriptors of the standard output and standard error.

        Returns:
            The process; None if it must be started in the usual way, which is always the case if the launcher has no
            standard output.
        """
        script = python_script(words, environ)
        # If the launcher has no standard streams, neither has the server.
        has_closed_stream = None in (sys.__stdin__, sys.__stdout__, sys.__stderr__)
        if script is None or has_closed_stream or not os.path.isdir(folder):
            return None
        shared_variables = {name: value for name, value in environ.items() if name.startswith(SHARED_VARIABLE_PREFIXES)}
        server_key = tuple(sorted(shared_variables.items()))
        try:
            server = self._servers.get(server_key)
            if server is None:
                other_variables = {
                    name: value
                    for name, value in self._environ.items()
                    if not name.startswith(SHARED_VARIABLE_PREFIXES)
                }
                server = self._servers[server_key] = _Server({**other_variables, **shared_variables})
            return server.fork(script, words[words.index(script) + 1 :], environ, folder, out, err)
        except (OSError, ValueError):  # ValueError: strings that JSON cannot represent
            return None

    def close(self) -> None:
        """Stop the servers. Call this only when all forked processes have exited."""
        for server in self._servers.values():
            server.close()
        self._servers.clear()


def python_script(words: Sequence[str], environ: Mapping[str, str]) -> str | None:
    """Return the script that a command line runs with this process's interpreter; None if it runs something else.

    Args:
        words: the command line.
        environ: the environment of the command; only PATH is used.
    """
    if words[0] == sys.executable and len(words) > 1 and not words[1].startswith("-"):
        return words[1]
    interpreter = _find_interpreter(Path(words[0]), environ)
    if interpreter is None or not _is_this_interpreter(interpreter):
        return None
    return words[0]


def _find_interpreter(script: Path, environ: Mapping[str, str]) -> str | None:
    try:
        with script.open("rb") as stream:
            line = stream.readline(_MAX_SHEBANG_LENGTH)
    except OSError:
        return None
    if not line.startswith(b"#!") or not line.endswith(b"\n"):
        return None
    command = line[2:].decode(errors="replace").split()
    if len(command) == 2 and command[0] == "/usr/bin/env" and command[1].startswith("python"):
        from shutil import which  # noqa: PLC0415 - slow: it imports all compression modules

        return which(command[1], path=environ.get("PATH"))
    return command[0] if len(command) == 1 and "python" in os.path.basename(command[0]) else None


def _is_this_interpreter(path: str) -> bool:
    """Return whether a file is this process's interpreter, in the same virtual environment."""
    interpreter_folder = os.path.dirname(os.path.abspath(sys.executable))
    return (
        os.path.realpath(path) == os.path.realpath(sys.executable)
        and os.path.dirname(os.path.abspath(path)) == interpreter_folder
    )
