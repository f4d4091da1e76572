"""Programs of stock's packages on stock's modules and on ours: the program's own modules stay stock's."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from faces import START, environ
from harness import SOURCE, STOCK_PYTHON, Master, Process

PACKAGES = Path("/usr/lib/python3/dist-packages")
CATKIN = ("catkin", "catkin_pkg", "pyparsing", "dateutil", "docutils", "six", "Cryptodome", "gnupg")
"""Modules that stock's tools need besides those of ROS."""


def link_modules(folder: Path, names: Iterable[str]) -> Path:
    """Fill a folder with links to some of stock's modules, and return it: nothing else of stock's is found there."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        file = name if (PACKAGES / name).exists() else f"{name}.py"
        (folder / file).symlink_to(PACKAGES / file)
    return folder


def command(face: str, words: list[str]) -> list[str]:
    """Return the command line of a program on stock's modules or ours; its name may leave out ``/usr/bin/``."""
    path = words[0] if words[0].startswith("/") else f"/usr/bin/{words[0]}"
    python = [STOCK_PYTHON] if face == "stock" else [sys.executable]
    return [*python, "-W", "ignore", path, *words[1:]]


def surroundings(face: str, master: Master, modules: Path, **extra: str | None) -> dict[str, str]:
    """Return the environment of a program; on ours it finds the modules that are linked in a folder."""
    if face == "stock":
        return environ("stock", master, **extra)
    return environ("ours", master, **{"PYTHONPATH": f"{START}:{SOURCE}:{modules}", **extra})


def said(
    face: str, master: Master, modules: Path, words: list[str], cwd: Path | None = None, **extra: str | None
) -> tuple[int, str]:
    """Return the exit code and the output of a program that ends by itself, without what differs between two runs."""
    done = subprocess.run(
        command(face, words),
        env=surroundings(face, master, modules, **extra),
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, comparable(done.stdout)


def begin(face: str, master: Master, modules: Path, words: list[str], **extra: str | None) -> Process:
    """Start a program; it ends with the test (use the fixture ``launcher`` as the master)."""
    process = Process(command(face, words), surroundings(face, master, modules, **extra), label=f"{words[0]} on {face}")
    master.processes.append(process)
    return process


def comparable(text: str) -> str:
    """Return an output without numbers of processes, ports and times."""
    text = re.sub(r"(http|rosrpc)://[\w.-]+:\d+", r"\1://ADDRESS", text)
    text = re.sub(r"_\d+_\d{10,}", "_ANONYMOUS", text)
    text = re.sub(r"time=[\d.]+ms|average: [\d.]+ms", "TIME", text)
    text = re.sub(r"Pid: \d+|port \d+|\[[\w.:-]+ on socket \d+\]|:\d{4,5}\b", "NUMBER", text)
    text = re.sub(r"(?m)^\d{19},", "TIME,", text)
    text = re.sub(r"\bseq: \d+", "seq: NUMBER", text)  # a latched message gets a new one for each subscriber
    text = re.sub(r"\bsecs: -\d{9,}\n(\s*)nsecs: +\d+", r"TIME", text)
    text = re.sub(r"search path .*", "search path", text)
    text = text.replace("the rosdep view is empty: call 'sudo rosdep init' and 'rosdep update'\n", "")
    return re.sub(r"\n{2,}", "\n", text)
