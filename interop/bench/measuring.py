"""What the roles measure with. The same as in `roscpp_measuring.hpp`."""

from __future__ import annotations

import os
import resource
import time
from pathlib import Path

now = time.perf_counter
"""The system's monotonic clock, which is the same in all processes, in seconds."""


def share(seconds: list[float], part: float) -> float:
    """The value in microseconds that this part of the times does not exceed."""
    return sorted(seconds)[int(len(seconds) * part)] * 1e6 if seconds else float("nan")


def cpu_seconds() -> float:
    """What this process has used of the processor so far, user and system."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class Cpu:
    """What this process takes of the processor, from now on."""

    def __init__(self) -> None:
        self.start, self._used = now(), cpu_seconds()

    def percent(self) -> float:
        return (cpu_seconds() - self._used) / (now() - self.start) * 100


def since_start() -> float:
    """Seconds since this process began, to 10 ms."""
    begun = int(Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[19])
    return time.clock_gettime(time.CLOCK_BOOTTIME) - begun / os.sysconf("SC_CLK_TCK")


def status(key: str) -> int:
    """A number of /proc/self/status; sizes are in kB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1])
    raise KeyError(key)


def ready() -> None:
    print("ready", flush=True)


def figures(**values: float) -> None:
    print("figures " + " ".join(f"{name}={value:.2f}" for name, value in values.items()), flush=True)
