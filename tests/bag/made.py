"""The kinds of bag that are tested, whole and damaged; stock's tools read the same ones in interop."""

from __future__ import annotations

from pathlib import Path

from pyros1.bag import BagWriter
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import make_bag_header, make_record
from pyros1.msgs import Message, load_message

from ..bodies import encode
from .old_bags import Old, number, old_bag, text

_NS = 1_000_000_000


def header_of(cls: type[Message], **more: str) -> dict[str, bytes]:
    """Return a connection header, as a publisher sends it."""
    fields = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in fields.items()}


def write_bag(
    path: Path, count: int = 100, compression: str = "none", chunk_threshold: int = 1000, close: bool = True
) -> Path:
    """Write a bag with numbers on /a and texts on /b: message i is at 100 s + i * 10 ms, and holds i."""
    number_type, text_type = load_message("std_msgs/Int32"), load_message("std_msgs/String")
    writer = BagWriter(path, compression, chunk_threshold)
    a = writer.add_connection("/a", header_of(number_type, callerid="/talker", latching="1", tcp_nodelay="0"))
    b = writer.add_connection("/b", header_of(text_type, callerid="/other"))
    for i in range(count):
        time = 100 * _NS + i * 10_000_000
        if i % 2:
            writer.write(b, time, encode(text_type(data=str(i))))
        else:
            writer.write(a, time, encode(number_type(data=i)))
    if close:
        writer.close()
    else:
        writer.flush()
        writer.abort()
    return path


def old_messages(count: int = 12) -> list[Old]:
    """Return numbers on /a and texts on /b, as `write_bag` writes them."""
    stamps = [100 * _NS + i * 10_000_000 for i in range(count)]
    return [text("/b", time, str(i)) if i % 2 else number("/a", time, i) for i, time in enumerate(stamps)]


def whole_bags(folder: Path) -> dict[str, Path]:
    """Make a bag of every kind that is whole; returns them by kind."""
    made = {}
    for compression in ("none", "bz2", "lz4"):
        made[compression] = write_bag(folder / f"{compression}.bag", compression=compression)
    made["one chunk"] = write_bag(folder / "one.bag", chunk_threshold=1 << 20)
    made["empty"] = write_bag(folder / "empty.bag", count=0)
    olds = {
        "1.2": old_bag(old_messages()),
        "1.2, latched": old_bag([text("/b", i * _NS, str(i), "/talker") for i in range(1, 5)]),
        "1.2 without index": old_bag(old_messages(), indexed=False),
        "1.2 with 2.0's word": old_bag(old_messages(), first_line=b"#ROSBAG V1.2\n"),
    }
    return made | {kind: _put(folder / f"old{i}.bag", data) for i, (kind, data) in enumerate(olds.items())}


def damaged_bags(folder: Path) -> dict[str, Path]:
    """Make a bag of every kind that is not whole; returns them by kind."""
    made = {}
    for compression in ("none", "bz2", "lz4"):
        made[f"not closed, {compression}"] = write_bag(folder / f"u{compression}.bag", 100, compression, close=False)
        data = write_bag(folder / f"c{compression}.bag", compression=compression).read_bytes()
        made[f"cut, {compression}"] = _put(folder / f"c{compression}.bag", data[: len(data) // 2 + 1500])
    path = write_bag(folder / "spoilt.bag")
    with BagReader(path) as bag:
        place = bag.chunks[3].pos
    data = path.read_bytes()
    made["spoilt chunk"] = _put(path, data[:place] + bytes(120) + data[place + 120 :])
    with BagReader(write_bag(folder / "open.bag", chunk_threshold=1 << 20)) as bag:
        content = bag.content(bag.chunks[0])[0]
    opened = make_record({"compression": b"none", "op": b"\5", "size": bytes(4)})  # stock's recorder fills it in later
    made["open chunk"] = _put(folder / "open.bag", b"#ROSBAG V2.0\n" + make_bag_header() + opened + content[:-3])
    olds = {
        "1.2, not closed": old_bag(old_messages(), closed=False),
        "1.2, cut": old_bag(old_messages())[:-40],
        "1.2 without index, cut": old_bag(old_messages(), indexed=False)[:-3],
    }
    return made | {kind: _put(folder / f"bad{i}.bag", data) for i, (kind, data) in enumerate(olds.items())}


def _put(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path
