"""Fuzzers of files: bags of both versions, MCAP files, journals of masters."""

from __future__ import annotations

import contextlib
import io
import struct
import tempfile
import zlib
from functools import cache
from pathlib import Path

from pyros1.bag import BagError
from pyros1.bag.edit.reindex import reindex
from pyros1.bag.export import mcap
from pyros1.bag.export.mcap_reader import McapReader
from pyros1.bag.format.compression import compress
from pyros1.bag.format.reader import BagReader
from pyros1.bag.info import info_text, summarize
from pyros1.master.journal import decode_records, encode_record

from ..bag.made import damaged_bags, whole_bags, write_bag
from .fuzzer import MEGABYTE, Fuzzer, words

LIMIT = MEGABYTE
"""Bytes of the largest content of a chunk that is read."""


def bag(data: bytes) -> None:
    """Read a bag by its index and without, and repair it."""
    for unindexed in (False, True):
        with (
            contextlib.suppress(BagError),
            BagReader(io.BytesIO(data), unindexed=unindexed, chunk_limit=LIMIT) as reader,
        ):
            info_text(summarize(reader, frequencies=True))
            for message in reader.messages():
                assert len(message.data) <= LIMIT
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "a.bag"), Path(folder, "b.bag")
        source.write_bytes(data)
        with contextlib.suppress(BagError):
            reindex(source, target)
            with BagReader(target) as repaired:
                assert len([*repaired.messages()]) <= len(data)


def mcap_file(data: bytes) -> None:
    """Read an MCAP file, and check it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.mcap")
        path.write_bytes(data)
        with contextlib.suppress(BagError), McapReader(path) as reader:
            for _, _, body in reader.messages():
                assert len(body) < 256 * MEGABYTE
        with McapReader(path) as reader:
            reader.check()


def journal(data: bytes) -> None:
    """Read the records of a journal."""
    calls = [*decode_records(data)]
    assert len(calls) <= len(data)


@cache
def _bags() -> list[bytes]:
    with tempfile.TemporaryDirectory() as folder:
        paths = [*whole_bags(Path(folder)).values(), *damaged_bags(Path(folder)).values()]
        small = [write_bag(Path(folder, f"{kind}.bag"), 4, kind, 200) for kind in ("none", "lz4", "bz2")]
        return [path.read_bytes() for path in [*small, *paths] if path.stat().st_size < 12_000]


def _mcap() -> list[bytes]:
    def put(op: int, *parts: bytes) -> bytes:
        return bytes(mcap.pack_record(op, *parts))

    schema = mcap.pack_schema(mcap.Schema(1, "std_msgs/String", "ros1msg", b"string data\n"))
    channel = mcap.pack_channel(mcap.Channel(1, 1, "/a", "ros1", {"callerid": "/n"}))
    message = put(mcap.OP_MESSAGE, mcap.MESSAGE_HEADER.pack(1, 1, 5, 5), b"\1\0\0\0a")
    records = schema + channel + message
    end = put(mcap.OP_DATA_END, bytes(4)) + put(mcap.OP_FOOTER, bytes(20)) + mcap.MAGIC
    found = [records]
    for name in ("", "lz4"):
        stored = b"".join(compress(name, [records])) if name else records
        head = struct.pack("<QQQI", 5, 5, len(records), zlib.crc32(records))
        found.append(put(mcap.OP_CHUNK, head, mcap.pack_string(name), struct.pack("<Q", len(stored)), stored))
    return [mcap.MAGIC + mcap.pack_header("ros1", "") + each + end for each in found]


_NUMBERS = [struct.pack("<I", number) for number in (0, 1, 4, 5, 4096, 1 << 20, (1 << 32) - 1)]
_BAG = words(
    r"""
    op=\x02  op=\x03  op=\x04  op=\x05  op=\x06  op=\x07  conn=\0\0\0\0  topic=/a  compression=bz2  #ROSBAG
    compression=lz4  compression=none  size=\xff\xff\xff\xff  index_pos=  chunk_count=  encryptor=x
    #ROSBAG V2.0\n  #ROSRECORD V1.2\n  #ROSRECORD V1.1\n  md5sum=*  type=std_msgs/String  chunk_pos=
    """
)

FUZZERS = {
    "bag": Fuzzer(bag, (), [*_BAG, *_NUMBERS], _bags, largest=1 << 14, memory=32 * MEGABYTE),
    "mcap": Fuzzer(mcap_file, (BagError,), [*_NUMBERS, b"lz4", b"zstd", mcap.MAGIC, b"ros1msg", b"/a"], _mcap),
    "journal": Fuzzer(journal, (), _NUMBERS, lambda: [encode_record(("setParam", ["/n", "/p", [1, "x"]])) * 2]),
}
