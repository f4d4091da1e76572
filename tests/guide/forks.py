"""Commands of pyros1 that start in 20 ms: a process that has loaded pyros1 forks for each of them.

The guide has some eighty commands, and nearly all of their time would go into starts of Python.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

LOADED = (
    "pyros1.actions", "pyros1.bag.api", "pyros1.cli.dispatch", "pyros1.cli.running", "pyros1.finding.library",
    "pyros1.graph", "pyros1.launch.reading.loader", "pyros1.launch.running.session", "pyros1.master.server",
    "pyros1.msgs.rosgraph_msgs.msg", "pyros1.msgs.std_msgs.msg", "pyros1.node", "pyros1.observe.statistics",
    "pyros1.tf", "pyros1.values", "yaml",
)  # fmt: skip


class Forks:
    """Starts commands of pyros1, each in a process and session of its own."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-u", __file__, str(theirs.fileno())], pass_fds=[theirs.fileno()]
            )

    def start(self, words: list[str], folder: Path, environ: dict[str, str], output: int) -> int:
        """Start a command.

        Args:
            words: the command line.
            folder: where it runs.
            environ: its environment variables.
            output: file descriptor for what it prints.

        Returns:
            The number of the process. Nobody need wait for its end.
        """
        with self._turn:
            socket.send_fds(self._ours, [json.dumps([words, str(folder), environ]).encode() + b"\n"], [output])
            return int(self._ours.recv(100))

    def close(self) -> None:
        """Start nothing any more."""
        self._ours.close()
        self._process.wait(10.0)


def serve(requests: socket.socket) -> list[str] | None:
    """Fork for each request. Return the command line in a fork; None at the end."""
    while True:
        request, files, _, _ = socket.recv_fds(requests, 1 << 20, 1)
        while request and not request.endswith(b"\n"):
            request += requests.recv(1 << 20)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG if request else 0)[0]:
                pass
        if not request:
            return None
        if (pid := os.fork()) == 0:
            break
        os.close(files[0])
        requests.sendall(str(pid).encode())
    requests.close()
    os.setsid()
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    for number in (1, 2):
        os.dup2(files[0], number)
    os.close(files[0])
    words, folder, environ = json.loads(request)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environ)
    return list(words)


if __name__ == "__main__":
    del sys.path[0]
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for module in LOADED:
        __import__(module)
    gc.freeze()  # else collections in forks would copy the memory of this process
    line = serve(socket.socket(fileno=int(sys.argv[1])))
    if line is not None:
        from pyros1.cli.main import entry

        sys.argv = line
        code = entry()
        sys.stdout.flush()
        os._exit(code)  # without taking apart what is loaded, which would copy it, too
