"""The processor time that is left for a program: idle processors, and the limits of control groups."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pyros1.net import processors
from pyros1.net.processors import Limit, ProcessorTimes, could_poll, find_group_folders, read_limit


@pytest.mark.parametrize(
    ("policy", "found"), [("SCHED_OTHER", False), ("SCHED_BATCH", False), ("SCHED_FIFO", True), ("SCHED_RR", True)]
)
@pytest.mark.skipif(not hasattr(os, "SCHED_RESET_ON_FORK"), reason="needs Linux")
def test_realtime_priorities(monkeypatch: pytest.MonkeyPatch, policy: str, found: bool) -> None:
    assert not processors.has_realtime_priority()
    for flag in (0, os.SCHED_RESET_ON_FORK):
        monkeypatch.setattr(os, "sched_getscheduler", lambda pid, flag=flag: getattr(os, policy) | flag)
        assert processors.has_realtime_priority() is found


@pytest.mark.skipif(not Path("/proc/stat").exists(), reason="needs Linux")
def test_the_idle_time_grows_no_faster_than_all_processors_together() -> None:
    start, first = time.monotonic(), processors.idle_time()
    assert first is not None and first > 0.0
    while (later := processors.idle_time()) == first and time.monotonic() < start + 0.1:
        pass
    assert later is not None and 0.0 <= later - first <= (time.monotonic() - start + 0.03) * (os.cpu_count() or 1)


@pytest.mark.parametrize(("numbers", "ticks"), [({0}, 4005), ({1, 10}, 77), ({0, 1, 10, 11}, 4082), (set(), 0)])
def test_the_idle_time_of_some_processors(numbers: set[int], ticks: int) -> None:
    """Idle processors and those that wait for disks count; those that are switched off have no line."""
    text = b"""cpu  9 9 9 999999 9 9 9 9 0 0
cpu0 1 2 3 4000 5 6 7 8 0 0
cpu1 1 2 3 70 0 6 7 8 0 0
cpu10 1 2 3 0 7 6 7 8 0 0
intr 123456 0 1
cpu11 0 0 0 1 1
"""
    assert processors.sum_idle_ticks(text.splitlines(keepends=True), numbers) == ticks


@pytest.mark.parametrize("line", [b"cpu0 1 2 3\n", b"cpu0 1 2 3 four 5\n", b"cpus 1 2 3 4 5\n", b"\n"])
def test_odd_lines_of_processors(line: bytes) -> None:
    with pytest.raises((ValueError, IndexError)):
        processors.sum_idle_ticks([line], {0})


@pytest.mark.parametrize(
    ("idle", "polls"),
    [((5.0, 5.0), False), ((5.0, 5.9), False), ((5.0, 6.1), True), ((None, 6.1), True), ((5.0, None), True)],
)
def test_polling_needs_an_idle_processor(idle: tuple[float | None, float | None], polls: bool) -> None:
    """At least half a one, on average."""
    before, now = idle
    assert could_poll(ProcessorTimes(10.0, before, {}), ProcessorTimes(12.0, now, {})) is polls


@pytest.mark.parametrize(
    ("processors_allowed", "used", "polls"),
    [
        (1.0, (3.0, 3.2), False),
        (1.5, (3.0, 3.9), True),
        (1.5, (3.0, 4.1), False),
        (4.0, (3.0, 8.9), True),
        (4.0, (3.0, 9.1), False),
        (1.9, (None, None), False),
        (2.0, (None, None), True),
        (2.0, (None, 9.0), True),
        (1.9, (9.0, None), False),
    ],
)
def test_polling_needs_a_processor_within_the_limit(
    processors_allowed: float, used: tuple[float | None, float | None], polls: bool
) -> None:
    """If the use is unknown, it may be a processor."""
    before, now = (
        ProcessorTimes(at, at, {"unlimited enough": Limit(9.0, at), "inner": Limit(processors_allowed, used_by_then)})
        for at, used_by_then in zip((10.0, 12.0), used, strict=True)
    )
    assert could_poll(before, now) is polls


def test_limits_that_come_and_go() -> None:
    without, with_limit = ProcessorTimes(10.0, 0.0, {}), ProcessorTimes(11.0, 2.0, {"group": Limit(1.5, 70.0)})
    assert not could_poll(without, with_limit)
    assert could_poll(with_limit, ProcessorTimes(12.0, 4.0, {}))


@pytest.mark.parametrize(
    ("lines", "folders"),
    [
        (["0::/\n"], ["/g"]),
        (["0::/system.slice/robot.service\n"], ["/g", "/g/system.slice", "/g/system.slice/robot.service"]),
        (["0::/../../other\n"], ["/g"]),
        (["3:cpu,cpuacct:/docker/5a\n", "2:cpuset:/x\n"], ["/g/cpu", "/g/cpu/docker", "/g/cpu/docker/5a"]),
        (["9:name=systemd:/a\n", "1:cpu:/a:b\n", "0::/\n"], ["/g/cpu", "/g/cpu/a:b", "/g"]),
        ([], []),
    ],
)
def test_the_folders_of_control_groups(lines: list[str], folders: list[str]) -> None:
    assert list(find_group_folders(lines, "/g")) == folders


def test_the_depth_of_control_groups_is_limited() -> None:
    assert len(list(find_group_folders(["0::" + "/a" * 10_000], "/g"))) < 100


def test_odd_lines_of_control_groups() -> None:
    with pytest.raises(ValueError, match="unpack"):
        list(find_group_folders(["0:/"], "/g"))


@pytest.mark.parametrize(
    ("files", "limit"),
    [
        ({"cpu.max": "150000 100000\n", "cpu.stat": "usage_usec 2500000\nuser_usec 1\n"}, Limit(1.5, 2.5)),
        ({"cpu.max": "50000 100000\n", "cpu.stat": "nr_periods 0\n"}, Limit(0.5, None)),
        ({"cpu.max": "50000 100000\n"}, Limit(0.5, None)),
        ({"cpu.max": "max 100000\n", "cpu.stat": "usage_usec 2500000\n"}, None),
        (
            {"cpu.cfs_quota_us": "400000\n", "cpu.cfs_period_us": "100000\n", "cpuacct.usage": "7000000000\n"},
            Limit(4.0, 7.0),
        ),
        (
            {"cpu.cfs_quota_us": "400000\n", "cpu.cfs_period_us": "100000\n", "cpu.stat": "nr_periods 0\n"},
            Limit(4.0, None),
        ),
        ({"cpu.cfs_quota_us": "-1\n", "cpu.cfs_period_us": "100000\n"}, None),
        ({"cpu.max": "lots\n"}, None),
        ({"cpu.max": "1 0\n"}, None),
        ({"cpu.max": ""}, None),
        ({"cpu.max": "50000 100000\n", "cpu.stat": "usage_usec many\n"}, Limit(0.5, None)),
        ({}, None),
    ],
)
def test_the_limit_of_a_control_group(tmp_path: Path, files: dict[str, str], limit: Limit | None) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert read_limit(str(tmp_path)) == limit


def test_what_the_system_tells() -> None:
    before, now = processors.read_processor_times(), processors.read_processor_times()
    assert before.at <= now.at
    assert all(limit.processors > 0 for limit in now.limits.values())


def test_reading_processor_times_imports_nothing() -> None:
    """A call may begin in a signal handler that has interrupted another one: an import that is not finished fails."""
    code = """if True:
        import sys
        from pyros1.net.processors import read_processor_times
        before = {*sys.modules}
        read_processor_times()
        sys.exit(", ".join({*sys.modules} - before) or 0)
        """
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
