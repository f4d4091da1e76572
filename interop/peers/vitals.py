"""What a process uses, and limits on it that a test sets and lifts while it runs."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from harness import Process

_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


class Vitals(NamedTuple):
    """What a process uses.

    Attributes:
        files: open descriptors.
        threads: its threads.
        memory: bytes in memory.
    """

    files: int
    threads: int
    memory: int


def vitals(pid: int) -> Vitals:
    """What a process uses now."""
    folder = Path(f"/proc/{pid}")
    memory = int((folder / "statm").read_text().split()[1]) * _PAGE
    return Vitals(len(os.listdir(folder / "fd")), len(os.listdir(folder / "task")), memory)


def cpu_seconds(pid: int) -> float:
    """The processor time that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


def cpu_clock(pid: int) -> float:
    """The same, to the nanosecond: the system's clock of a process (see clock_getcpuclockid)."""
    return time.clock_gettime((~pid << 3) | 2)


def busy(pid: int, seconds: float) -> float:
    """The share of a processor that a process uses for a while."""
    begun, before = time.monotonic(), cpu_seconds(pid)
    time.sleep(seconds)
    return (cpu_seconds(pid) - before) / (time.monotonic() - begun)


@contextlib.contextmanager
def limited(pid: int, kind: int, most: int) -> Iterator[None]:
    """Limit the number of a process's descriptors (``RLIMIT_NOFILE``) or the size of its files (``RLIMIT_FSIZE``)."""
    soft, hard = resource.prlimit(pid, kind)
    resource.prlimit(pid, kind, (most, hard))
    try:
        yield
    finally:
        resource.prlimit(pid, kind, (soft, hard))


@contextlib.contextmanager
def stopped(*processes: Process) -> Iterator[None]:
    """Let processes stand still, as Ctrl-Z does; returns when all their threads do."""
    for process in processes:
        process.signal(signal.SIGSTOP)
    try:
        for process in processes:
            deadline = time.monotonic() + 10
            while not _stands_still(process.pid):
                assert time.monotonic() < deadline, f"{process.pid} does not stop"
                time.sleep(0.005)
        yield
    finally:
        for process in processes:
            process.signal(signal.SIGCONT)


def _stands_still(pid: int) -> bool:
    states = (stat.read_text().rpartition(")")[2].split()[0] for stat in Path(f"/proc/{pid}/task").glob("*/stat"))
    return all(state in "Tt" for state in states)
