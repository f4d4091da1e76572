"""The conditions under which the steps are run: on a quiet machine, beside busy programs, on one core, with less of the
processor's time.

What is measured inherits the condition from the process that measures: a processor, a control group.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path

QUIET = "quiet"
_CPU_BURNER = "while True: pass"
_MEMORY_BURNER = "source = bytearray(64 << 20); target = bytearray(len(source))\nwhile True: target[:] = source"
_CONTAINER_PERIOD = 100_000  # us, as container runtimes set it
_CLOCK_PERIOD = 4_000  # us; short, so that programs seem to run slowly rather than to stop for long


@contextmanager
def busy() -> Iterator[None]:
    """As many programs as cores, each of which uses one whole; one of them is limited by the memory's bandwidth."""
    codes = [_MEMORY_BURNER, *[_CPU_BURNER] * (len(os.sched_getaffinity(0)) - 1)]
    burners = [subprocess.Popen([sys.executable, "-c", code]) for code in codes]
    try:
        yield
    finally:
        for burner in burners:
            burner.kill()
        for burner in burners:
            burner.wait()


@contextmanager
def pinned() -> Iterator[None]:
    """All programs on one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


@contextmanager
def quota(cores: float, period: int) -> Iterator[None]:
    """All programs together may use so much of the processors' time, as in a container with such a limit.

    Args:
        cores: the limit, as the number of cores that could be used all the time.
        period: what is used in a period is limited, in microseconds.

    Raises:
        OSError: no control group can be made here; that needs root.
    """
    parent, files = _cpu_controller(round(cores * period), period)
    group = parent / f"bench.{os.getpid()}"
    group.mkdir()
    try:
        for name, text in files.items():
            (group / name).write_text(text)
        (group / "cgroup.procs").write_text("0")
        yield
    finally:
        for pid in (group / "cgroup.procs").read_text().split():
            with suppress(OSError):  # it has ended
                (parent / "cgroup.procs").write_text(pid)
        group.rmdir()


def _cpu_controller(used: int, period: int) -> tuple[Path, Mapping[str, str]]:
    """Return the folder of this process's control group, and the files that limit one inside it to so many microseconds
    of each period.
    """
    own = dict(line.split(":", 2)[1:] for line in Path("/proc/self/cgroup").read_text().splitlines())
    root = Path("/sys/fs/cgroup")
    for controllers, path in own.items():
        if "cpu" in controllers.split(","):  # version 1
            files = {"cpu.cfs_period_us": str(period), "cpu.cfs_quota_us": str(used)}
            return root / "cpu" / path.lstrip("/"), files
    return root / own[""].lstrip("/"), {"cpu.max": f"{used} {period}"}


def slowed(share: float) -> AbstractContextManager[None]:
    """A stand-in for processors of so much of the clock: all cores together may use that share of their time."""
    return quota(share * len(os.sched_getaffinity(0)), _CLOCK_PERIOD)


CONDITIONS: Mapping[str, Callable[[], AbstractContextManager[None]]] = {
    QUIET: nullcontext,
    "busy": busy,
    "quota": lambda: quota(1, _CONTAINER_PERIOD),
    "pinned": pinned,
    "half": lambda: slowed(0.5),
    "quarter": lambda: slowed(0.25),
}
