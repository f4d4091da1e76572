"""How much space a recording leaves on the disk."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pyros1.bag.errors import BagError
from pyros1.bag.record.disk_space import SpaceGuard
from pyros1.bag.record.model import RecordOptions

GB = 1 << 30


def test_a_warning_in_time_and_an_end_b22(monkeypatch: pytest.MonkeyPatch) -> None:
    free = 6 * GB
    seconds = iter(range(1000))  # each look at the clock is a second later
    monkeypatch.setattr("pyros1.bag.record.disk_space.time", SimpleNamespace(monotonic=lambda: float(next(seconds))))
    disk = SimpleNamespace(statvfs=lambda folder: SimpleNamespace(f_bavail=free // 4096, f_frsize=4096))
    monkeypatch.setattr("pyros1.bag.record.disk_space.os", disk)
    warnings: list[str] = []
    guard = SpaceGuard("/d", RecordOptions().min_space, warnings.append)
    guard.check()
    assert warnings == []
    free = 4 * GB
    for _ in range(60):
        guard.check()
    assert warnings == ["Less than 5 GiB of space free on the disk."] * 3, "one every 20 s"
    free = GB - 4096
    with pytest.raises(BagError, match="less than 1 GiB of space is free"):
        guard.check()
