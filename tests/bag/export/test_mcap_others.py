"""MCAP files between pyros1 and the library `mcap`, which those who made the format wrote: a second opinion."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag.export import mcap_writer
from pyros1.bag.format.reader import BagReader
from pyros1.cli.running import run_command
from pyros1.msgs import load_message

from ...bodies import encode
from ..conftest import Make

pytest.importorskip("mcap", reason="the extra `test` brings it")
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

Run = Callable[..., tuple[int, str, str]]
STRING = load_message("std_msgs/String")
START = 10**18


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, partial(run_command, "bag"))


@pytest.mark.parametrize("compression", CompressionType)
@pytest.mark.parametrize("chunks", [True, False])
def test_what_it_writes_is_imported(run: Run, tmp_path: Path, compression: Any, chunks: bool) -> None:
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=500, compression=compression, use_chunking=chunks, enable_data_crcs=True)
        writer.start("ros1")
        kind = writer.register_schema("std_msgs/String", "ros1msg", STRING._full_text.encode())
        told = {"callerid": "/p", "latching": "true", "md5sum": STRING._md5sum}
        channels = [writer.register_channel("/a", "ros1", kind, told), writer.register_channel("/b", "ros1", kind)]
        writer.add_metadata("robot", {"name": "r2"})
        expected = []
        for i in range(50):
            data = encode(STRING(data=f"m{i}"))
            expected.append((("/a", "/b")[i % 2], START + i, data))
            writer.add_message(channels[i % 2], START + i, data, START + i - 5, i)
            if i == 25:
                writer.add_attachment(START, START, "photo", "image/png", bytes(3000))
        writer.finish()
    assert run("import", "x.mcap") == (0, "x.bag: 50 messages of 2 topics\n", "")
    with BagReader(tmp_path / "x.bag") as bag:
        assert [(m.connection.topic, m.time, bytes(m.data)) for m in bag.messages()] == expected
        a, b = sorted(bag.connections.values(), key=lambda each: each.topic)
        assert (a.text("callerid"), a.latching, b.latching) == ("/p", True, False)
        assert {a.md5sum, b.md5sum} == {STRING._md5sum}


def test_it_reads_what_is_exported(run: Run, make_bag: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the index, forwards and backwards, and one topic; with all checksums."""
    monkeypatch.setattr(mcap_writer, "CHUNK_THRESHOLD", 500)
    make_bag(count=60)
    assert run("export", "x.bag", "-o", "x.mcap", "--ros1")[0] == 0
    with BagReader(tmp_path / "x.bag") as bag:
        stored = [(m.connection.topic, m.time, bytes(m.data)) for m in bag.messages()]
        definitions = {(c.type, c.definition) for c in bag.connections.values()}
    with (tmp_path / "x.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros1"
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert (summary.statistics.message_count, summary.statistics.chunk_count) == (60, len(summary.chunk_indexes))
        assert len(summary.chunk_indexes) > 2
        schemas = summary.schemas.values()
        assert {(s.name, s.data.decode()) for s in schemas if s.encoding == "ros1msg"} == definitions

        def found(**wanted: Any) -> list[tuple[str, int, bytes]]:
            return [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages(**wanted)]

        assert found() == stored
        assert found(reverse=True) == stored[::-1]
        assert found(topics=["/b"]) == [each for each in stored if each[0] == "/b"]
