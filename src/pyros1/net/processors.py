"""How much processor time is left for this program: idle processors, within the limits of its control groups.

Containers and services may have such a limit, see https://docs.kernel.org/admin-guide/cgroup-v2.html (``cpu.max``), and
https://docs.kernel.org/scheduler/sched-bwc.html for version 1 of control groups.
"""

from __future__ import annotations

import os
import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Final, NamedTuple

_MIN_IDLE: Final = 0.5
_GROUPS: Final = "/sys/fs/cgroup"
_MAX_DEPTH: Final = 32


class Limit(NamedTuple):
    """The limit of a control group.

    Attributes:
        processors: the number of processors that its programs may use on average.
        used: the processor time in seconds that they have used so far; None if unknown.
    """

    processors: float
    used: float | None


class ProcessorTimes(NamedTuple):
    """Processor times in seconds, at some time.

    Attributes:
        at: the time in seconds on the monotonic clock.
        idle: the total time for which the processors that the thread may use have been idle; None if unknown.
        limits: the limits of the control groups of this program, by their folders.
    """

    at: float
    idle: float | None
    limits: Mapping[str, Limit]


def read_processor_times() -> ProcessorTimes:
    """Return the processor times of the calling thread. What the system does not report is unknown."""
    return ProcessorTimes(time.monotonic(), idle_time(), dict(_read_limits()))


def could_poll(before: ProcessorTimes, now: ProcessorTimes) -> bool:
    """Return whether a thread that slept between two times could have polled instead, at the cost of no other program.

    So at least half a processor was idle on average, and each limit left a whole one. If the use of a group is unknown,
    it is taken to be one processor. If idle times are unknown, processors are taken to be idle.
    """
    seconds = now.at - before.at
    if before.idle is not None and now.idle is not None and now.idle - before.idle < _MIN_IDLE * seconds:
        return False
    for folder, limit in now.limits.items():
        used_before = before.limits[folder].used if folder in before.limits else None
        used = seconds if limit.used is None or used_before is None else limit.used - used_before
        if limit.processors * seconds - used < seconds:
            return False
    return True


def idle_time() -> float | None:
    """Return the total time in seconds for which the processors that the calling thread may use have been idle; None
    if the system does not report it.
    """
    try:
        with open("/proc/stat", "rb") as file:
            return sum_idle_ticks(file, os.sched_getaffinity(0)) / os.sysconf("SC_CLK_TCK") or None
    except (OSError, ValueError, IndexError, AttributeError):
        return None


def sum_idle_ticks(lines: Iterable[bytes], processors: Collection[int]) -> int:
    """Return for how many ticks some processors have been idle or waiting for disks.

    Args:
        lines: lines in the format of /proc/stat; those of processors come first.
        processors: the numbers of the processors.

    Raises:
        ValueError, IndexError: the lines are not in that format.
    """
    total = 0
    for line in lines:
        name, *fields = line.split()
        if not name.startswith(b"cpu"):
            break
        if name != b"cpu" and int(name[3:]) in processors:
            total += int(fields[3]) + int(fields[4])
    return total


def has_realtime_priority() -> bool:
    """Return whether the calling thread runs before all programs of normal priority."""
    try:
        return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK in (os.SCHED_FIFO, os.SCHED_RR)
    except (OSError, AttributeError):  # not on this system
        return False


def _read_limits() -> Iterator[tuple[str, Limit]]:
    with suppress(OSError, ValueError), open("/proc/self/cgroup", encoding="utf-8", errors="surrogateescape") as file:
        for folder in find_group_folders(file, _GROUPS):
            limit = read_limit(folder)
            if limit is not None:
                yield folder, limit


def find_group_folders(lines: Iterable[str], root: str) -> Iterator[str]:
    """Yield the folders in which the limits of a process may be: that of its group and those of the groups around it.

    Args:
        lines: the lines of its /proc/PID/cgroup.
        root: the folder with the control groups, normally /sys/fs/cgroup.

    Raises:
        ValueError: the lines are not in that format.
    """
    for line in lines:
        _, controllers, path = line.rstrip("\n").split(":", 2)
        if not controllers:
            folder = root
        elif "cpu" in controllers.split(","):
            folder = f"{root}/cpu"
        else:
            continue
        yield folder
        # In a container, the path may be the host's, whose folders do not exist there.
        for name in path.strip("/").split("/")[:_MAX_DEPTH]:
            if name in ("", ".."):  # the group is outside the container
                break
            folder = f"{folder}/{name}"
            yield folder


def read_limit(folder: str) -> Limit | None:
    """Return the limit of the control group with this folder; None if it has none."""
    try:
        if os.path.exists(f"{folder}/cpu.max"):
            quota, period = _read(f"{folder}/cpu.max").split()
            read_used = _read_used
        else:  # version 1
            quota, period = _read(f"{folder}/cpu.cfs_quota_us"), _read(f"{folder}/cpu.cfs_period_us")
            read_used = _read_used_of_version_1
        return Limit(int(quota) / int(period), read_used(folder)) if quota != "max" and int(quota) > 0 else None
    except (OSError, ValueError, ZeroDivisionError):
        return None


def _read_used(folder: str) -> float | None:
    with suppress(OSError, ValueError):
        for line in _read(f"{folder}/cpu.stat").splitlines():
            name, _, value = line.partition(" ")
            if name == "usage_usec":
                return int(value) / 1e6
    return None


def _read_used_of_version_1(folder: str) -> float | None:
    with suppress(OSError, ValueError):  # the two controllers need not share their groups
        return int(_read(f"{folder}/cpuacct.usage")) / 1e9
    return None


def _read(path: str) -> str:
    # Not as ASCII: a signal handler that interrupts the import of its codec would find no such encoding.
    with open(path, encoding="utf-8") as file:
        return file.read(1 << 16)
