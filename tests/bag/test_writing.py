"""Bags written by programs: `pyros1.bag.open(path, "w")`.

Feature: bags written by programs -- `pyros1.bag.open(path, "w")`, or `"a"`; what is left after a crash or a full disk
    can be reindexed
"""

from __future__ import annotations

import errno
import io
import subprocess
import sys
import threading
import time
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1 import Time
from pyros1.bag import BagError, BagWriter, UnindexedError
from pyros1.bag.edit.reindex import reindex
from pyros1.bag.format import writer
from pyros1.bag.format.writer import EMPTY_BAG_SIZE
from pyros1.ground.errors import SerializationError
from pyros1.guide.documents import pages
from pyros1.msgs import AnyMsg
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.msgs.std_msgs.msg import Int32, String

from .old_bags import number, old_bag


def content(path: Any) -> list[tuple[str, Any, float]]:
    with pyros1.bag.open(path, unindexed=False) as bag:
        return [(item.topic, item.message.data, item.time.to_sec()) for item in bag.messages()]


def test_the_example_of_the_page(tmp_path: Path) -> None:
    program = pages()["bags"].code("python")[0]
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0].startswith("/counter ")


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_what_is_written_is_read(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "x.bag"
    with pyros1.bag.open(path, "w", compression=compression, chunk_threshold=200) as bag:
        for i in range(50):
            bag.write("/a", Int32(i), Time(10, i))
            bag.write("/b", String(str(i)), 20.0 + i)
        assert len(bag) == 100 and bag.path == str(path)
    assert content(path) == sorted(
        [("/a", i, Time(10, i).to_sec()) for i in range(50)] + [("/b", str(i), 20.0 + i) for i in range(50)],
        key=lambda item: item[2],
    )
    with pyros1.bag.open(path) as read:
        assert list(read.summary().storage) == [compression]


def test_more_is_written_behind(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    for i in range(4):
        with pyros1.bag.open(path, "a", chunk_threshold=1) as bag:
            assert len(bag) == i
            bag.write("/a", Int32(i), float(i + 1))
    assert content(path) == [("/a", i, i + 1.0) for i in range(4)]
    before = path.read_bytes()
    pyros1.bag.open(path, "a").close()
    assert path.read_bytes() == before


def test_a_crash_while_more_is_written_loses_nothing_of_before(tmp_path: Path) -> None:
    path, repaired = tmp_path / "x.bag", tmp_path / "y.bag"
    with pyros1.bag.open(path, "w") as bag:
        bag.write("/a", Int32(1), 1.0)
    bag = pyros1.bag.open(path, "a")
    bag.write("/a", Int32(2), 2.0)
    bag.flush()
    bag.write("/a", Int32(3), 3.0)
    bag.writer.abort()  # as a crash does
    with pytest.raises(UnindexedError, match="pyros1 bag reindex"):
        pyros1.bag.open(path, unindexed=False)
    with pytest.raises(UnindexedError, match="pyros1 bag reindex"):
        pyros1.bag.open(path, "a")
    assert reindex(path, repaired).messages == 2
    assert content(repaired) == [("/a", 1, 1.0), ("/a", 2, 2.0)]


def test_kill_leaves_what_was_handed_over(tmp_path: Path) -> None:
    program = (
        "import os, signal, pyros1.bag\n"
        "from pyros1.msgs.std_msgs.msg import Int32\n"
        "bag = pyros1.bag.open('x.bag', 'w')\n"
        "for i in range(9):\n"
        "    bag.write('/a', Int32(i), i + 1.0)\n"
        "bag.flush()\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, timeout=60, check=False)
    assert reindex(tmp_path / "x.bag", tmp_path / "y.bag").messages == 9
    assert [item[1] for item in content(tmp_path / "y.bag")] == list(range(9))


def test_an_exception_leaves_a_complete_bag(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with pytest.raises(RuntimeError, match="mine"), pyros1.bag.open(path, "w") as bag:
        bag.write("/a", Int32(1), 1.0)
        raise RuntimeError("mine")
    assert content(path) == [("/a", 1, 1.0)]
    bag.close()


def test_headers(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    header = {"type": "std_msgs/Int32", "md5sum": Int32._md5sum, "message_definition": Int32._full_text}
    with pyros1.bag.open(path, "w") as bag:
        bag.write("/a", Int32(1), 1.0)
        bag.write("/a", Int32(2), 2.0, {**header, "callerid": "/me", "latching": b"1"})
        bag.write("/a", Int32(3), 3.0, {**header, "callerid": "/me", "latching": b"1"})
        bag.write("/a", AnyMsg(b"\4\0\0\0", {**header, "callerid": "/you"}), 4.0)
        bag.write_raw("/a", b"\5\0\0\0", header, 5.0)
        with pytest.raises(BagError, match="'type'"):
            bag.write("/a", AnyMsg(b"\4\0\0\0"))
    with pyros1.bag.open(path) as read:
        assert [item.message.data for item in read] == [1, 2, 3, 4, 5]
        assert [each.callerid for each in read.connections] == ["", "/me", "/you", ""]
        assert [each.latching for each in read.connections] == [False, True, False, False]


def test_what_does_not_fit_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with pyros1.bag.open(path, "w") as bag:
        with pytest.raises(SerializationError):
            bag.write("/a", Int32("many"), 1.0)  # type: ignore[arg-type]
        with pytest.raises(BagError, match="0 to 2\\^32"):
            bag.write("/a", Int32(1), -1.0)
    with pyros1.bag.open(path) as read:
        assert len(read) == 0
    with pytest.raises(ValueError, match="'x'"):
        pyros1.bag.open(path, "x")  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="zip"):
        pyros1.bag.open(path, "w", compression="zip")


def test_old_bags_get_no_more(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    path.write_bytes(old_bag([number("/a", 10**9, 1)]))
    with pytest.raises(BagError, match=r"version 1\.2"):
        pyros1.bag.open(path, "a")


def test_file_objects(tmp_path: Path) -> None:
    memory = io.BytesIO(b"something else" * 1000)
    with pyros1.bag.open(memory, "w") as bag:
        bag.write("/a", Int32(1), 1.0)
    with pyros1.bag.open(memory, "a") as bag:
        bag.write("/a", Int32(2), 2.0)
    assert content(memory) == [("/a", 1, 1.0), ("/a", 2, 2.0)]
    path = tmp_path / "x.bag"
    with open(path, "w+b") as file, pyros1.bag.open(file, "w") as bag:
        bag.write("/a", Int32(1), 1.0)
    with open(path, "rb") as file:
        assert content(file) == [("/a", 1, 1.0)]
        assert not file.closed


def test_threads(tmp_path: Path) -> None:
    with pyros1.bag.open(tmp_path / "x.bag", "w", chunk_threshold=500) as bag:

        def write(topic: str) -> None:
            for i in range(200):
                bag.write(topic, Int32(i), i + 1.0)

        threads = [threading.Thread(target=write, args=(f"/t{n}",)) for n in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
    for n in range(4):
        with pyros1.bag.open(tmp_path / "x.bag") as read:
            assert [item.message.data for item in read.messages(f"/t{n}")] == list(range(200))


def test_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was written before can be saved; a bag that could not even begin leaves no file."""
    room = EMPTY_BAG_SIZE + 10_000

    class Full(FileIO):
        def write(self, data: Any) -> int:
            if self.tell() + len(data) > room:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(data)

    monkeypatch.setattr(writer, "FileIO", Full)
    path = tmp_path / "x.bag"
    bag = pyros1.bag.open(path, "w", chunk_threshold=1)
    with pytest.raises(OSError, match="No space left"):
        for i in range(100):
            bag.write("/a", Imu(), i + 1.0)
    count = len(bag)
    assert count > 0
    room = 0
    with pytest.raises(OSError, match="No space left"):
        bag.close()
    room = 1 << 30
    assert reindex(path, tmp_path / "y.bag").messages == count
    room = 100
    for make in (BagWriter, lambda path: pyros1.bag.open(path, "w")):
        with pytest.raises(OSError, match=r"z\.bag"):
            make(tmp_path / "z.bag")
        assert not (tmp_path / "z.bag").exists()


def test_now_is_the_default(tmp_path: Path) -> None:
    with pyros1.bag.open(tmp_path / "x.bag", "w") as bag:
        bag.write("/a", Int32(1))
    with pyros1.bag.open(tmp_path / "x.bag") as read:
        ((_, _, stamp, _),) = read
        assert abs(stamp.to_sec() - time.time()) < 60


def test_threads_read_one_bag_at_once(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with pyros1.bag.open(path, "w", chunk_threshold=300) as out:
        for number in range(400):
            out.write("/t", Int32(number), Time(number))
    read: list[list[int]] = []
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with pyros1.bag.open(path) as bag:
            threads = [
                threading.Thread(target=lambda: read.append([each.message.data for each in bag.messages()]))
                for _ in range(4)
            ]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join(30)
    finally:
        sys.setswitchinterval(interval)
    assert read == [list(range(400))] * 4
