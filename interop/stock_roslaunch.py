"""Stock roslaunch for many questions: one process imports it, and each question is answered by a fork of that process.

Each line of standard input is a JSON object with ``words`` (the command line), ``cwd`` and ``env`` (variables to set);
each line of standard output one with ``code``, ``out`` and ``err``. Runs on the Python of the stock installation.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from typing import Any

import roslaunch


def answer(question: dict[str, Any]) -> dict[str, Any]:
    """Run roslaunch in a fork and return what it printed."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        pid = os.fork()
        if pid == 0:
            code = 1
            try:
                os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                os.chdir(question["cwd"])
                os.environ.update(question["env"])
                sys.argv = ["roslaunch", *question["words"]]
                roslaunch.main(sys.argv)
                code = 0
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        _, status = os.waitpid(pid, 0)
        out.seek(0)
        err.seek(0)
        return {"code": os.waitstatus_to_exitcode(status), "out": out.read(), "err": err.read()}


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(answer(json.loads(line))), flush=True)
