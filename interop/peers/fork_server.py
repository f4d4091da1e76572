"""Starts Python programs quickly: one process imports what they need, and each program runs in a fork of it.

A stock node or tool needs about half a second to import its modules, a fork of this process a fiftieth of that.

    fork_server.py SOCKET [MODULE | beneath:MODULE]...

SOCKET is the number of an inherited SOCK_SEQPACKET socket. A request is a JSON object with ``words`` (the program's
path and its arguments), ``cwd``, ``env`` (the whole environment), ``session`` (whether it gets a session of its own),
and ``timeout`` (whole seconds until SIGALRM ends the program; 0 for no limit). Four descriptors come with it:
standard input, output and error of the program, and a pipe that gets its process id at once and its exit code in the
end (negative: the signal), each as four bytes. With ``beneath:MODULE``, all that MODULE imports is imported, but not
that package itself: it may look at its environment while it is imported. Also runs on the Python of the stock
installation.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import io
import json
import os
import random
import runpy
import selectors
import signal
import socket
import sys
import threading
import time
from typing import Any, NoReturn


def become(request: dict[str, Any], files: list[int]) -> NoReturn:
    """Run the program in this process, a fork, as if it had been started; ends as the program ends."""
    code = 1
    try:
        prepare(request, files)
        runpy.run_path(sys.argv[0], run_name="__main__")
        code = 0
    except SystemExit as end:
        if isinstance(end.code, int):
            code = end.code
        elif end.code is None:
            code = 0
        else:
            print(end.code, file=sys.stderr)
    except BaseException as error:  # noqa: BLE001  reported as an interpreter does
        sys.excepthook(*sys.exc_info())
        if isinstance(error, KeyboardInterrupt):
            code = -signal.SIGINT
    # What an interpreter does at its end, without taking apart all modules, which takes longer than everything else.
    threading._shutdown()  # type: ignore[attr-defined]
    core = sys.modules.get("rospy.core")
    if hasattr(core, "_ros_atexit") and not core.is_initialized():  # it would sleep for 0.1 s and do nothing
        atexit.unregister(core._ros_atexit)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    if code == -signal.SIGINT:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)
    os._exit(code & 0xFF)


def prepare(request: dict[str, Any], files: list[int]) -> None:
    """Give this process the surroundings of the program."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    if request["session"]:
        os.setsid()
    signal.alarm(request["timeout"])
    for number, file in enumerate(files):
        os.dup2(file, number)
    os.closerange(3, 1024)  # those of this server and of its other children
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  for the rest of the process
    if request["env"].get("PYTHONUNBUFFERED"):
        sys.stdout = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), "utf-8", write_through=True)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    time.tzset()
    random.seed()
    numpy = sys.modules.get("numpy")
    if numpy is not None:
        numpy.random.seed()
    sys.argv[:] = request["words"]  # in place: modules may have kept the list
    paths = request["env"].get("PYTHONPATH", "")
    sys.path[:1] = [os.path.dirname(sys.argv[0]), *filter(None, paths.split(os.pathsep))]


def load(name: str) -> None:
    """Import a module, or ``beneath:`` and a package: what that one imports."""
    package = name.partition("beneath:")[2]
    if not package:
        importlib.import_module(name)
        return
    read_end, write_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        importlib.import_module(package)
        with open(write_end, "w") as pipe:
            pipe.write("\n".join(module for module in sys.modules if module.partition(".")[0] != package))
        os._exit(0)
    os.close(write_end)
    with open(read_end) as pipe:
        names = pipe.read().split("\n")
    os.waitpid(pid, 0)
    for module in names:
        with contextlib.suppress(ImportError):
            importlib.import_module(module)


def main() -> None:
    """Start programs until the socket is closed; then kill those that still run."""
    control = socket.socket(fileno=int(sys.argv[1]))
    for name in sys.argv[2:]:
        load(name)
    gc.collect()
    gc.freeze()  # collections in the forks need not look at what was imported, nor copy its pages
    woken, wake = os.pipe()
    for end in (woken, wake):
        os.set_blocking(end, False)
    signal.set_wakeup_fd(wake)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    selector = selectors.DefaultSelector()
    selector.register(control, selectors.EVENT_READ)
    selector.register(woken, selectors.EVENT_READ)
    pipes: dict[int, int] = {}  # process id -> the pipe for its exit code
    while True:
        for key, _ in selector.select():
            if key.fileobj is control:
                data, files, _, _ = socket.recv_fds(control, 1 << 20, 4)
                if not data:
                    for pid in pipes:
                        os.kill(pid, signal.SIGKILL)
                    return
                pid = os.fork()
                if pid == 0:
                    become(json.loads(data), files[:3])
                pipes[pid] = files[3]
                os.write(files[3], pid.to_bytes(4, "little"))
                for file in files[:3]:
                    os.close(file)
            else:
                os.read(woken, 4096)
                reap(pipes)


def reap(pipes: dict[int, int]) -> None:
    """Pass on the exit codes of the programs that have ended."""
    for pid in list(pipes):
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            pipe = pipes.pop(pid)
            with contextlib.suppress(BrokenPipeError):
                os.write(pipe, os.waitstatus_to_exitcode(status).to_bytes(4, "little", signed=True))
            os.close(pipe)


if __name__ == "__main__":
    main()
