"""Reading bags: `pyros1 bag info` and `pyros1.bag` beside stock's `rosbag info` and `rosbag` module, and rosbags.

::

    python interop/bench/bag_reading.py SIDE BAG      # read a bag's messages, decoded; prints how many in a second
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().parents[2] / "src"
STOCK_PYTHON = "/usr/bin/python3"
BEGIN = 1_700_000_000 * 10**9
MESSAGES = 30_000
IMAGE = 6_220_800
LARGE = 10_000_000_000


def make_bag(path: Path, type_name: str) -> None:
    """Write a bag of MESSAGES messages of a type, empty but for their numbers."""
    from pyros1.bag import BagWriter
    from pyros1.msgs import load_message

    cls: Any = load_message(type_name)
    with BagWriter(path) as bag:
        conn = bag.add_connection("/topic", connection_header(cls))
        for number in range(MESSAGES):
            message = cls()
            if cls._has_header:
                message.header.seq = number
            bag.write(conn, BEGIN + number * 10**6, cls._encode(message))


def make_large_bag(path: Path) -> None:
    """Write a bag of LARGE bytes of images, whose pixels are holes in the file: it takes little of the disk."""
    from pyros1.bag import BagWriter
    from pyros1.msgs import load_message

    class Sparse(BagWriter):
        def _write_fully(self, data: Any) -> None:
            if len(data) == IMAGE:
                self._file.seek(IMAGE, 1)
            else:
                super()._write_fully(data)

    cls: Any = load_message("sensor_msgs/Image")
    pixels = memoryview(bytes(IMAGE))
    with Sparse(path) as bag:
        conn = bag.add_connection("/camera", connection_header(cls))
        for number in range(LARGE // IMAGE):
            bag.write(conn, BEGIN + number * 33_333_333, pixels)


def connection_header(cls: Any) -> dict[str, bytes]:
    """The connection header of a publisher of a type."""
    fields = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, "callerid": "/load"}
    return {name: text.encode() for name, text in fields.items()}


def info_time(side: str, env: dict[str, str], folder: Path) -> float:
    """The seconds that `info` of a bag of 10 GB takes, from the command's start to its end."""
    bag = folder / "large.bag"
    if not bag.exists():
        make_large_bag(bag)
    command = [sys.executable, "-m", "pyros1", "bag"] if side == "ours" else ["rosbag"]
    began = time.perf_counter()
    subprocess.run([*command, "info", str(bag)], env=env, check=True, stdout=subprocess.DEVNULL, timeout=120)
    return time.perf_counter() - began


def reading_rate(side: str, type_name: str, env: dict[str, str], folder: Path) -> float:
    """The messages of a type that a side reads and decodes in a second.

    Args:
        side: ``ours``, ``stock`` (its Python module), or ``rosbags``.
    """
    bag = folder / f"{type_name.replace('/', '_')}.bag"
    if not bag.exists():
        make_bag(bag, type_name)
    python = STOCK_PYTHON if side == "stock" else sys.executable
    done = subprocess.run(
        [python, __file__, side, str(bag)], env=env, check=True, capture_output=True, text=True, timeout=120
    )
    return float(done.stdout)


def read(side: str, path: str) -> int:
    """Read and decode all messages of a bag; return their number."""
    count = 0
    if side == "ours":
        import pyros1.bag

        with pyros1.bag.open(path) as bag:
            for _ in bag.messages():
                count += 1
    elif side == "stock":
        import rosbag

        with rosbag.Bag(path) as stock_bag:
            for _ in stock_bag.read_messages():
                count += 1
    else:
        from rosbags.highlevel import AnyReader

        with AnyReader([Path(path)]) as reader:
            for connection, _, data in reader.messages():
                reader.deserialize(data, connection.msgtype)
                count += 1
    return count


if __name__ == "__main__":
    start = time.perf_counter()
    number_read = read(*sys.argv[1:])
    print(number_read / (time.perf_counter() - start))
