"""Information about a bag, as the rows or the YAML that ``bag info`` prints (L114-L116)."""

from __future__ import annotations

import heapq
import time
from array import array
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any

from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS_PER_S
from pyros1.ground.terminal_text import untrusted

_MAX_STAMPS = 10_000_000
"""Maximum number of messages from which frequencies are computed, since even a small file can contain any number."""


@dataclass(frozen=True)
class Storage:
    """The chunks with one type of compression.

    Attributes:
        chunks: number of chunks.
        size: size of their contents in bytes.
        stored_size: size of their contents as stored, in bytes.
    """

    chunks: int
    size: int
    stored_size: int


@dataclass(frozen=True)
class Topic:
    """A topic in a bag.

    Attributes:
        name: name, as recorded.
        type: type of its messages.
        messages: number of messages.
        connections: number of publishers.
        frequency: median frequency in Hz; None if unknown.
    """

    name: str
    type: str
    messages: int
    connections: int
    frequency: float | None


@dataclass(frozen=True)
class Summary:
    """Information about a bag.

    Attributes:
        path: path of the bag file.
        version: version of the format, for example ``2.0``.
        size: size of the file in bytes.
        start: time of the first message in seconds, from the index.
        end: time of the last message in seconds.
        messages: number of messages.
        storage: compression -> the chunks that use it.
        types: type -> md5 sum.
        topics: the topics, sorted by name.
        is_empty: whether there are neither messages nor connections.
        encryption: name of the encryptor; empty if the bag is not encrypted.
        gpg_user: the user whose key is needed to decrypt the bag.
    """

    path: str
    version: str
    size: int
    start: float
    end: float
    messages: int
    storage: dict[str, Storage]
    types: dict[str, str]
    topics: list[Topic]
    is_empty: bool
    encryption: str = ""
    gpg_user: str = ""

    @property
    def duration(self) -> float:
        """Seconds between the first and the last message."""
        return self.end - self.start

    @property
    def is_compressed(self) -> bool:
        """Whether any chunk is compressed."""
        return any(name != "none" for name in self.storage)

    @property
    def sizes(self) -> tuple[int, int]:
        """Total size of the chunks' contents, and total size of their stored bytes."""
        return sum(part.size for part in self.storage.values()), sum(part.stored_size for part in self.storage.values())


def summarize(bag: BagReader, *, frequencies: bool = False) -> Summary:
    """Return information about a bag. Without `frequencies`, only its index and the chunks' headers are read.

    Raises:
        BagError: the bag cannot be read.
    """
    chunks = bag.chunks
    connections = bag.connections
    if frequencies:
        used_ids = {conn for chunk in chunks for conn in chunk.counts}
        connections = {conn_id: connection for conn_id, connection in connections.items() if conn_id in used_ids}
    types: dict[str, str] = {}
    ids_by_topic: dict[str, list[int]] = {}
    for conn_id, connection in connections.items():
        types.setdefault(connection.type, connection.md5sum)
        ids_by_topic.setdefault(untrusted(connection.topic), []).append(conn_id)
    is_old = bag.file.version == 102
    # Stock always prints frequencies for old bags.
    topics = summarize_topics(bag, ids_by_topic, frequencies=frequencies or is_old)
    version = "1.2" if is_old else "2.0"
    is_indexed = bag.file.index_pos > 0 if is_old else not bag.was_scanned
    # As in stock ROS, these are the times of the index's first and last chunk, even if the index is unsorted.
    start, end = (bag.start, bag.end) if is_old or not chunks else (chunks[0].start, chunks[-1].end)
    return Summary(
        path=bag.path,
        version=version if is_indexed else f"{version} (unindexed)",
        size=bag.file.size,
        start=start / NS_PER_S,
        end=end / NS_PER_S,
        messages=bag.count(),
        storage={} if is_old else _storage_by_compression(bag),
        types={untrusted(name): untrusted(md5sum) for name, md5sum in sorted(types.items())},
        topics=topics,
        is_empty=not bag.chunks and not bag.connections,
        encryption=untrusted(bag.file.encryptor_name),
        gpg_user=untrusted(bag.file.header.get("gpg_user", b"").decode("utf-8", "replace")),
    )


def summarize_topics(bag: BagReader, ids_by_topic: Mapping[str, list[int]], *, frequencies: bool) -> list[Topic]:
    """Return information about the given topics, sorted by name.

    Args:
        bag: the bag to describe.
        ids_by_topic: topic -> ids of its connections, at least one per topic.
        frequencies: whether to compute frequencies, for which the whole index is read.
    """
    counts: dict[int, int] = {}
    for chunk in bag.chunks:
        for conn, count in chunk.counts.items():
            counts[conn] = counts.get(conn, 0) + count
    frequency_by_topic = _compute_frequencies(bag, ids_by_topic) if frequencies else {}
    return [
        Topic(
            name,
            untrusted(bag.connections[conn_ids[0]].type),
            sum(counts.get(conn_id, 0) for conn_id in conn_ids),
            len(conn_ids),
            frequency_by_topic.get(name),
        )
        for name, conn_ids in sorted(ids_by_topic.items())
    ]


def _storage_by_compression(bag: BagReader) -> dict[str, Storage]:
    storage: dict[str, Storage] = {}
    for header in bag.headers():
        previous = storage.get(header.compression, Storage(0, 0, 0))
        storage[header.compression] = Storage(
            previous.chunks + 1, previous.size + header.size, previous.stored_size + header.stored_size
        )
    return storage


def _compute_frequencies(bag: BagReader, ids_by_topic: Mapping[str, list[int]]) -> dict[str, float]:
    from statistics import median  # noqa: PLC0415 - slow to import, and rarely needed

    times: dict[int, array[float]] = {conn_id: array("d") for conn_ids in ids_by_topic.values() for conn_id in conn_ids}
    for conn_id, stamp in islice(bag.times(), _MAX_STAMPS):
        if conn_id in times:
            times[conn_id].append(stamp / NS_PER_S)
    frequency_by_topic = {}
    for name, conn_ids in ids_by_topic.items():
        stamps = heapq.merge(
            *(times[conn_id] for conn_id in conn_ids)
        )  # as in stock ROS, out of order if chunks overlap
        periods = array("d", (later - earlier for earlier, later in pairwise(stamps)))
        period = median(periods) if periods else 0.0
        if period > 0:
            frequency_by_topic[name] = 1 / period
    return frequency_by_topic


# Rows ---------------------------------------------------------------------------------------------------------------


def info_text(summary: Summary) -> str:
    """Return the text that ``bag info`` prints, byte for byte like stock's."""
    rows = list(_summary_rows(summary))
    width = max(len(name) for name, _ in rows) + 1
    return "\n".join(f"{name + ':' if name else '':{width}} {value}" for name, value in rows).rstrip()


def _summary_rows(summary: Summary) -> Iterator[tuple[str, str]]:
    yield "path", summary.path
    yield "version", summary.version
    if summary.is_empty:
        yield "size", size_text(summary.size)
        return
    yield "duration", _duration_text(summary.duration)
    yield "start", _time_text(summary.start)
    yield "end", _time_text(summary.end)
    yield "size", size_text(summary.size)
    yield "messages", str(summary.messages)
    yield "compression", ", ".join(_compression_texts(summary.storage)) or "none"
    if summary.is_compressed:
        yield from _compressed_size_rows(summary)
    if summary.encryption:
        yield "encryption", summary.encryption
        yield "GPG key user", summary.gpg_user
    yield from _with_title("types", _type_rows(summary))
    yield from _with_title("topics", _topic_rows(summary.topics, max(map(len, summary.types), default=0)))


def _with_title(title: str, rows: Iterable[str]) -> Iterator[tuple[str, str]]:
    for index, row in enumerate(rows):
        yield "" if index else title, row


def _compression_texts(storage: dict[str, Storage]) -> Iterator[str]:
    total = sum(storage_part.chunks for storage_part in storage.values())
    for name, storage_part in sorted(storage.items(), key=lambda item: (item[1].chunks, item[0]), reverse=True):
        ratio = (
            f"; {100.0 * storage_part.stored_size / storage_part.size if storage_part.size else 0:.2f}%"
            if name != "none"
            else ""
        )
        yield f"{name} [{storage_part.chunks}/{total} chunks{ratio}]"


def _compressed_size_rows(summary: Summary) -> Iterator[tuple[str, str]]:
    sizes = summary.sizes
    texts = [size_text(size) for size in sizes]
    width = max(map(len, texts))
    rows = [f"{text:>{width}}" for text in texts]
    if summary.duration > 0:
        rates = [size_text(size / summary.duration) for size in sizes]
        width = max(map(len, rates))
        rows = [f"{row} @ {rate:>{width}}/s" for row, rate in zip(rows, rates, strict=True)]
        rows[1] += f" ({100.0 * sizes[1] / sizes[0] if sizes[0] else 0:.2f}%)"
    yield "uncompressed", rows[0]
    yield "compressed", rows[1]


def _type_rows(summary: Summary) -> Iterator[str]:
    width = max(map(len, summary.types), default=0)
    for name, md5 in summary.types.items():
        yield f"{name:{width}} [{md5}]"


def _topic_rows(topics: list[Topic], type_width: int) -> Iterator[str]:
    name_width = max((len(topic.name) for topic in topics), default=0)
    count_width = max((len(str(topic.messages)) for topic in topics), default=0)
    rates = ["" if topic.frequency is None else frequency_text(topic.frequency) for topic in topics]
    rate_width = max(map(len, rates), default=0)
    for topic, rate in zip(topics, rates, strict=True):
        noun = "msgs" if topic.messages > 1 else "msg "
        publishers = f" ({topic.connections} connections)" if topic.connections > 1 else ""
        yield (
            f"{topic.name:{name_width}}   {topic.messages:{count_width}} {noun} {'@' if rate else ' '} "
            f"{rate:>{rate_width}} : {topic.type:{type_width}}{publishers}"
        )


def _duration_text(duration: float) -> str:
    minutes, hours = int(duration / 60), int(duration / 3600)
    if hours > 0:
        return f"{hours}hr {minutes % 60}:{int(duration % 60):02d}s ({int(duration)}s)"
    if minutes > 0:
        return f"{minutes}:{int(duration % 60):02d}s ({int(duration)}s)"
    return f"{duration:.1f}s"


def _time_text(stamp: float) -> str:
    fraction = f"{stamp - int(stamp):.2f}"[1:]
    return f"{time.strftime('%b %d %Y %H:%M:%S', time.localtime(stamp))}{fraction} ({stamp:.2f})"


def size_text(size: float) -> str:
    """Return a number of bytes with a suitable unit, for example ``1.5 MB``."""
    return _with_unit(size / 1024, 1024, ("KB", "MB", "GB", "TB", "PB", "EB", "ZB", "YB"))


def frequency_text(frequency: float) -> str:
    """Return a frequency in Hz with a suitable unit, for example ``1.5 kHz``."""
    return _with_unit(frequency, 1000, ("Hz", "kHz", "MHz", "GHz", "THz", "PHz", "EHz", "ZHz", "YHz"))


def _with_unit(value: float, factor: float, units: tuple[str, ...]) -> str:
    for unit in units:
        if value < factor:
            return f"{value:.1f} {unit}"
        value /= factor
    return "-"


# YAML ---------------------------------------------------------------------------------------------------------------


def info_values(summary: Summary) -> dict[str, Any]:
    """Return the values that ``bag info -y`` prints. Floats are strings with a fixed number of digits."""
    values: dict[str, Any] = {"path": summary.path, "version": summary.version}
    if summary.is_empty:
        return values | {"size": summary.size, "indexed": False}
    stamps = {"duration": summary.duration, "start": summary.start, "end": summary.end}
    values |= {name: f"{stamp:.6f}" for name, stamp in stamps.items()}
    values |= {"size": summary.size, "messages": summary.messages, "indexed": "unindexed" not in summary.version}
    most_common = max(summary.storage.items(), key=lambda item: (item[1].chunks, item[0]), default=("none", None))
    values["compression"] = most_common[0]
    if summary.is_compressed:
        values["uncompressed"], values["compressed"] = summary.sizes
    if summary.encryption:
        values["encryption"], values["GPG key user"] = summary.encryption, summary.gpg_user
    values["types"] = [{"type": name, "md5": md5} for name, md5 in summary.types.items()]
    values["topics"] = [_topic_values(topic) for topic in summary.topics]
    return values


def _topic_values(topic: Topic) -> dict[str, Any]:
    values: dict[str, Any] = {"topic": topic.name, "type": topic.type, "messages": topic.messages}
    if topic.connections > 1:
        values["connections"] = topic.connections
    if topic.frequency is not None:
        values["frequency"] = f"{topic.frequency:.4f}"
    return values


def yaml_text(values: dict[str, Any]) -> str:
    """Return the YAML that ``bag info -y`` prints, byte for byte like stock's."""
    lines = []
    for name, value in values.items():
        if isinstance(value, list):
            lines.append(f"{name}:")
            for item in value:
                pairs = [f"{key}: {field_value}" for key, field_value in item.items()]
                lines += [f"    - {pairs[0]}", *(f"      {pair}" for pair in pairs[1:])]
        else:
            lines.append(f"{name}: {value}")
    return "\n".join(lines) + "\n"
