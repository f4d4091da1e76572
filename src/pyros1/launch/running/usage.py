"""Reads the CPU and memory usage of running processes from ``/proc`` on Linux; on other systems, usage is unknown."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import NamedTuple


class Usage(NamedTuple):
    """Total usage by the processes in a group.

    Attributes:
        cpu: CPU time used so far in seconds; negative if unknown.
        memory: resident memory in bytes; negative if unknown.
    """

    cpu: float
    memory: int


UNKNOWN_USAGE = Usage(-1.0, -1)


def group_usages(proc: Path = Path("/proc")) -> dict[int, Usage]:
    """Return the current usage of each process group, by the group's id.

    Args:
        proc: path of the proc file system.
    """
    try:
        ticks_per_second, page_size = os.sysconf("SC_CLK_TCK"), os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return {}
    usages: dict[int, Usage] = {}
    for stat in proc.glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # the process has just exited
            continue
        group, ticks, pages = int(fields[2]), int(fields[11]) + int(fields[12]), int(fields[21])
        previous = usages.get(group, Usage(0.0, 0))
        usages[group] = Usage(previous.cpu + ticks / ticks_per_second, previous.memory + pages * page_size)
    return usages


def process_age(pid: int, proc: Path = Path("/proc")) -> float:
    """Return the number of seconds since a process on this machine was started; negative if unknown.

    Args:
        pid: the process id.
        proc: path of the proc file system.
    """
    try:
        ticks = int((proc / str(pid) / "stat").read_text().rpartition(")")[2].split()[19])
        return max(0.0, time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK"))
    except (AttributeError, OSError, ValueError, IndexError):
        return -1.0


def launch_files(pid: int, proc: Path = Path("/proc")) -> str:
    """Return the names of the launch files on the command line of a process on this machine; empty if unknown.

    Args:
        pid: the process id.
        proc: path of the proc file system.
    """
    try:
        words = (proc / str(pid) / "cmdline").read_text(errors="replace").split("\0")
    except OSError:
        return ""
    return ",".join(os.path.basename(word) for word in words if word.endswith((".launch", ".launch.xml")))
