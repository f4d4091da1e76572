"""bag.format.files: single records of a file."""

from __future__ import annotations

import io
import struct
from contextlib import closing
from pathlib import Path

import pytest

from pyros1.bag.format.files import BagFile
from pyros1.bag.format.records import RecordError, make_record
from pyros1.bag.format.writer import BagWriter

DATA = b"data of the record"


@pytest.fixture
def head(tmp_path: Path) -> bytes:
    """The beginning of a bag, up to its first record."""
    path = tmp_path / "empty.bag"
    BagWriter(path).close()
    with closing(BagFile(path)) as bag:
        return path.read_bytes()[: bag.begin]


@pytest.mark.parametrize("length", [0, 400, 490, 500, 512, 5000])
def test_records_with_headers_of_any_size(head: bytes, length: int) -> None:
    """Some are longer than what is read at first."""
    name = b"x" * length
    record = make_record({"op": b"\x07", "name": name}, DATA)
    with closing(BagFile(io.BytesIO(head + record))) as bag:
        fields, data, size = bag.record(len(head))
        assert (fields["name"], size) == (name, len(DATA))
        assert bag.read(data, size) == DATA
        with pytest.raises(RecordError, match="the record is cut off"):
            bag.record(len(head) + len(record))


@pytest.mark.parametrize("length", [20, 5000])
def test_a_header_that_ends_behind_the_file(head: bytes, length: int) -> None:
    record = make_record({"op": b"\x07", "name": b"x" * length})
    for missing in (1, 5, 9):
        cut = head + record[:-missing]
        with (
            closing(BagFile(io.BytesIO(cut))) as bag,
            pytest.raises(RecordError, match="runs past the end of the file"),
        ):
            bag.record(len(head))
    with closing(BagFile(io.BytesIO(head + record))) as bag:
        assert bag.record(len(head))[2] == 0


@pytest.mark.parametrize("length", [20, 600])
def test_a_file_that_becomes_shorter_while_it_is_read(head: bytes, length: int) -> None:
    source = io.BytesIO(head + make_record({"op": b"\x07", "name": b"x" * length}))
    with closing(BagFile(source)) as bag:
        for missing in (1, 8, 12, 20):
            source.truncate(bag.size - 4 - missing)
            with pytest.raises(RecordError, match="the file was truncated while it was being read"):
                bag.record(len(head))


def test_what_is_no_record(head: bytes) -> None:
    with closing(BagFile(io.BytesIO(head + struct.pack("<I", 1 << 31) + bytes(20)))) as bag:
        with pytest.raises(RecordError, match="there is no record here: its header would have 2147483648 bytes"):
            bag.record(len(head))
        with pytest.raises(RecordError):
            bag.record(len(head) + 4)
