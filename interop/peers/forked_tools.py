"""Command-line tools for many questions: one process imports them, and each command line runs in a fork of it.

A stock tool needs about half a second to import what it needs, a fork of this process a fiftieth of that. The modules
to import are the arguments. Each line of standard input is a JSON object with ``words`` (the program's path and its
arguments), ``cwd``, ``env`` (the whole environment), ``stdin`` (text) and ``timeout`` (whole seconds, after which
SIGALRM ends the tool); each line of standard output one with ``code``, ``out`` and ``err``. Also runs on the Python of
the stock installation.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import random
import runpy
import signal
import sys
import tempfile
import threading
import time
from typing import IO, Any, NoReturn


def become(question: dict[str, Any], files: tuple[IO[bytes], IO[bytes], IO[bytes]]) -> NoReturn:
    """Run the program in this process, a fork, as if it had been started; ends as the program ends."""
    code = 1
    try:
        prepare(question, files)
        runpy.run_path(sys.argv[0], run_name="__main__")
        code = 0
    except SystemExit as end:
        if isinstance(end.code, int):
            code = end.code
        elif end.code is None:
            code = 0
        else:
            print(end.code, file=sys.stderr)
    except BaseException:  # noqa: BLE001  shown and ended as an interpreter does
        sys.excepthook(*sys.exc_info())
    # What an interpreter does at its end, without taking apart all modules, which takes longer than everything else.
    threading._shutdown()  # type: ignore[attr-defined]
    rospy = sys.modules.get("rospy")
    if rospy is None or rospy.core.is_initialized():  # else rospy would sleep for 0.1 s and do nothing
        atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code & 0xFF)


def prepare(question: dict[str, Any], files: tuple[IO[bytes], IO[bytes], IO[bytes]]) -> None:
    """Give this process the surroundings of the program."""
    signal.alarm(question["timeout"])
    for number, file in enumerate(files):
        os.dup2(file.fileno(), number)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  for the rest of the process
    os.chdir(question["cwd"])
    os.environ.clear()
    os.environ.update(question["env"])
    time.tzset()
    random.seed()
    sys.argv[:] = question["words"]  # in place: modules may have kept the list
    sys.path[0] = os.path.dirname(sys.argv[0])


def main() -> None:
    """Answer until standard input ends."""
    modules = sys.argv[1:]
    for name in modules:
        importlib.import_module(name)
    gc.freeze()  # collections in the forks need not look at what was imported, nor copy its pages
    for line in sys.stdin:
        question = json.loads(line)
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            given.write(question["stdin"].encode())
            given.seek(0)
            pid = os.fork()
            if pid == 0:
                become(question, (given, out, err))
            _, status = os.waitpid(pid, 0)
            out.seek(0)
            err.seek(0)
            answer = {
                "code": os.waitstatus_to_exitcode(status),
                "out": out.read().decode("utf-8", "surrogateescape"),
                "err": err.read().decode("utf-8", "surrogateescape"),
            }
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
