"""Python programs that start quickly, as forks of a process that has imported their modules: see fork_server.py."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

PEERS = Path(__file__).resolve().parent
SOURCE = PEERS.parent.parent / "src"


class ForkedProcess(subprocess.Popen[Any]):
    """A program that the server starts. It is no child of this process, so three methods of Popen are replaced.

    Args:
        server: this side of the server's socket.
        args: the path of the program, a Python script, and its arguments.
        alarm: seconds after which SIGALRM ends the program; 0 for no limit.
        options: further arguments of Popen.
    """

    def __init__(self, server: socket.socket, args: Sequence[str], *, alarm: int = 0, **options: Any) -> None:
        self._server, self._exit_pipe = server, -1
        self._request = {"timeout": alarm, "session": options.get("start_new_session", False)}
        super().__init__(args, **options)

    def _execute_child(self, args: Sequence[str], *options: Any) -> None:
        cwd, environ = options[4:6]
        pipes = options[9:15]  # (child's end, this end) for stdin; (this end, child's end) for stdout and for stderr
        files = [number if file == -1 else file for number, file in enumerate((pipes[0], pipes[3], pipes[5]))]
        environ = dict(os.environ if environ is None else environ)
        request = {"words": list(args), "cwd": str(cwd or os.getcwd()), "env": environ, **self._request}
        self._exit_pipe, their_pipe = os.pipe()
        try:
            socket.send_fds(self._server, [json.dumps(request).encode()], [*files, their_pipe])
        finally:
            os.close(their_pipe)
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]
        data = os.read(self._exit_pipe, 4)
        assert data, f"the server of forks ended instead of starting {args}"
        self.pid = int.from_bytes(data, "little")
        self._child_created = True

    def _internal_poll(self, _deadstate: int | None = None) -> int | None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._wait(0)
        return None

    def _wait(self, timeout: float | None) -> int:
        with self._waitpid_lock:  # type: ignore[attr-defined]
            if self.returncode is None:
                if not select.select([self._exit_pipe], [], [], timeout)[0]:
                    raise subprocess.TimeoutExpired(self.args, timeout or 0)
                data = os.read(self._exit_pipe, 4)
                os.close(self._exit_pipe)
                self.returncode = int.from_bytes(data, "little", signed=True) if data else -9  # the server has ended
            return self.returncode


class ForkServer:
    """Starts programs written in Python.

    Args:
        python: path of the interpreter, and its options.
        modules: what to import once; see ``fork_server.py``.
        folder: where programs are that are given by their names.
    """

    def __init__(self, python: Sequence[str], modules: Sequence[str], folder: Path) -> None:
        self._folder = folder
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            environ = {"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "ROS_HOSTNAME": "localhost"}
            self._server = subprocess.Popen(
                [*python, str(PEERS / "fork_server.py"), str(theirs.fileno()), *modules],
                env={**environ, "PYTHONPATH": str(SOURCE), "OPENBLAS_NUM_THREADS": "1"},
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )

    def start(self, words: Sequence[str], **options: Any) -> ForkedProcess:
        """Start a program, the name or path of a Python script, with its arguments; options as for ForkedProcess."""
        return ForkedProcess(self._socket, [str(self._folder / words[0]), *words[1:]], **options)

    def ask(
        self,
        words: Sequence[str],
        environ: Mapping[str, str],
        *,
        cwd: str | os.PathLike[str] = "/",
        stdin: str = "",
        timeout: float = 30,
        with_errors: bool = False,
    ) -> tuple[int, str, str]:
        """Run a program to its end; returns exit code (negative for a signal), stdout and stderr.

        Args:
            words: the program, the name or path of a Python script, and its arguments.
            environ: the whole environment of the program.
            cwd: its working directory.
            stdin: its standard input.
            timeout: seconds after which SIGALRM ends it.
            with_errors: whether stdout contains stderr.
        """
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            given.write(stdin.encode())
            given.seek(0)
            process = self.start(
                words,
                alarm=max(round(timeout), 1),
                env={**environ, "PYTHONUNBUFFERED": ""},  # many small pieces take long
                cwd=cwd,
                stdin=given,
                stdout=out,
                stderr=subprocess.STDOUT if with_errors else err,
                start_new_session=True,
            )
            code = process.wait()
            out.seek(0)
            err.seek(0)
            return code, out.read().decode("utf-8", "surrogateescape"), err.read().decode("utf-8", "surrogateescape")

    def close(self) -> None:
        """End the server, and the programs that still run."""
        self._socket.close()
        self._server.wait(15)
