"""CPU and memory usage of running processes, from ``/proc`` on Linux. Other systems report nothing."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple


class Usage(NamedTuple):
    """Total usage of the processes of a group.

    Attributes:
        cpu: CPU time so far in seconds; negative if unknown.
        memory: resident memory in bytes; negative if unknown.
    """

    cpu: float
    memory: int


UNKNOWN = Usage(-1.0, -1)


def group_usages(proc: Path = Path("/proc")) -> dict[int, Usage]:
    """Return the current usage of each process group, by the group's id.

    Args:
        proc: path of the proc file system.
    """
    try:
        tick, page = os.sysconf("SC_CLK_TCK"), os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return {}
    found: dict[int, Usage] = {}
    for stat in proc.glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        group, ticks, pages = int(fields[2]), int(fields[11]) + int(fields[12]), int(fields[21])
        before = found.get(group, Usage(0.0, 0))
        found[group] = Usage(before.cpu + ticks / tick, before.memory + pages * page)
    return found
