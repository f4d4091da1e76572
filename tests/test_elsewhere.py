"""Other systems: every module can be imported where Python lacks what only Unix has, as on Windows."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import importlib, os, pathlib, select, signal, socket, sys
for name in "fcntl termios tty pwd grp resource pty syslog curses readline".split():
    sys.modules[name] = None
LACKING = {
    os: "fork forkpty killpg getpgid setsid getuid geteuid getpgrp setpgid wait3 wait4 openpty getloadavg mkfifo chown",
    signal: "SIGKILL SIGHUP SIGQUIT SIGALRM SIGCHLD SIGCONT SIGSTOP SIGUSR1 SIGUSR2 SIGTSTP SIGPIPE SIGWINCH setitimer"
    " pthread_sigmask alarm sigwait pthread_kill pause",
    select: "epoll poll",
    socket: "AF_UNIX SO_REUSEPORT MSG_DONTWAIT TCP_KEEPIDLE TCP_USER_TIMEOUT",
}
for module, names in LACKING.items():
    for name in names.split():
        if hasattr(module, name):
            delattr(module, name)

import pyros1

root = pathlib.Path(pyros1.__file__).parent
others = {"packages", "templates", "modules", "start", "vendor"}  # programs, and what has other names
for path in sorted(root.rglob("*.py")):
    parts = path.relative_to(root.parent).with_suffix("").parts
    if others.isdisjoint(parts) and parts[-1] not in ("__main__", "build_backend"):
        name = ".".join(parts).removesuffix(".__init__")
        try:
            importlib.import_module(name)
        except Exception as error:
            print(f"{name}: {type(error).__name__}: {error}")
print(len(sys.modules) > 500)
"""


def test_all_modules_are_imported_where_nothing_of_unix_is() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=100, check=False)
    assert (done.stdout, done.stderr) == ("True\n", "")
