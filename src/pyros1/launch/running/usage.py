"""What running processes use of the machine; Linux tells it in ``/proc``, other systems do not."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple


class Usage(NamedTuple):
    """What the processes of one group use together.

    Attributes:
        cpu: processor time so far, seconds; negative if it is not known.
        memory: resident memory, bytes; negative if it is not known.
    """

    cpu: float
    memory: int


UNKNOWN = Usage(-1.0, -1)


def group_usages(proc: Path = Path("/proc")) -> dict[int, Usage]:
    """Return what each process group uses now, by the group's number.

    Args:
        proc: where the system shows its processes.
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
