"""The conditions under which the steps are run: on a quiet machine, beside busy programs, with a quota, on one core.

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
_PERIOD = 100_000  # us, as containers have it


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
def quota() -> Iterator[None]:
    """All programs together may use the time of one core, as in a container with such a limit.

    Raises:
        OSError: no control group can be made here; that needs root.
    """
    parent, files = _cpu_controller()
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


def _cpu_controller() -> tuple[Path, Mapping[str, str]]:
    """Return the folder of this process's control group, and the files that limit one inside it to one core."""
    own = dict(line.split(":", 2)[1:] for line in Path("/proc/self/cgroup").read_text().splitlines())
    root = Path("/sys/fs/cgroup")
    for controllers, path in own.items():
        if "cpu" in controllers.split(","):  # version 1
            files = {"cpu.cfs_period_us": str(_PERIOD), "cpu.cfs_quota_us": str(_PERIOD)}
            return root / "cpu" / path.lstrip("/"), files
    return root / own[""].lstrip("/"), {"cpu.max": f"{_PERIOD} {_PERIOD}"}


CONDITIONS: Mapping[str, Callable[[], AbstractContextManager[None]]] = {
    QUIET: nullcontext,
    "busy": busy,
    "quota": quota,
    "pinned": pinned,
}
