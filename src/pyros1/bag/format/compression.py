"""Compression of chunks: none, bz2 and lz4."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from typing import Any

from pyros1.bag.format.records import LimitError, RecordError

COMPRESSIONS = ("none", "bz2", "lz4")

MAX_CHUNK_SIZE = 1 << 31
"""Maximum size in bytes of the content of a chunk that pyros1 writes."""


def check_size(size: int, limit: int) -> None:
    """Raise LimitError if a chunk or record claims to hold more bytes than the limit."""
    if size > limit:
        raise LimitError(
            f"it claims to hold {size} bytes; the limit is {limit} (--chunk-limit MIB raises it, if you trust the file)"
        )


_BZ2_MAX_LEVEL = 9
_LZ4_BLOCK_SIZE_1_MB = 6
_PIECE_SIZE = 1 << 20
"""Number of bytes that are compressed or decompressed at a time."""
_SMALL_PIECE_SIZE = 4096

Buffer = bytes | bytearray | memoryview


def compress(compression: str, parts: Sequence[Buffer]) -> Sequence[Buffer]:
    """Return a chunk's compressed content in parts: it may be large, and is never copied as a whole.

    Args:
        compression: one of `COMPRESSIONS`.
        parts: the content, in parts.
    """
    if compression == "bz2":
        import bz2  # noqa: PLC0415 - most bags do not need it

        compressor = bz2.BZ2Compressor(_BZ2_MAX_LEVEL)
        return [*map(compressor.compress, _split_into_pieces(parts)), compressor.flush()]
    if compression == "lz4":
        # Stock's readers reject frames that state their content's size, have no checksum, or have blocks that depend on
        # earlier blocks.
        frame = _import_lz4().LZ4FrameCompressor(
            block_size=_LZ4_BLOCK_SIZE_1_MB, block_linked=False, content_checksum=True
        )
        return [frame.begin(), *map(frame.compress, _split_into_pieces(parts)), frame.flush()]
    return parts


def _split_into_pieces(parts: Sequence[Buffer]) -> Iterator[memoryview]:
    for part in parts:
        view = memoryview(part)
        for start in range(0, len(view), _PIECE_SIZE):
            yield view[start : start + _PIECE_SIZE]


def decompress(compression: str, data: bytes, size: int, limit: int, *, partial: bool = False) -> bytes:
    """Return a stored chunk's content, at most `size` bytes, so that a damaged chunk cannot exhaust memory.

    Args:
        compression: name of the compression, from the chunk's header.
        data: the stored bytes.
        size: size of the content in bytes, from the chunk's header.
        limit: maximum number of bytes of content.
        partial: whether the chunk may be cut off or damaged; if so, the readable part is returned.

    Raises:
        RecordError: the compression is unknown, the content is larger than the limit, or the bytes are damaged.
    """
    if compression not in COMPRESSIONS:
        raise RecordError(f"the chunk's compression {compression[:20]!r} is unknown")
    if partial:
        size = min(size, limit)
    check_size(size, limit)
    content = data if compression == "none" else _decompress(compression, data, size, partial)
    if len(content) != size and not partial:
        raise RecordError(f"the chunk holds {len(content)} bytes instead of {size}")
    return content


def _decompress(compression: str, data: bytes, size: int, partial: bool) -> bytes:
    if compression == "bz2":
        import bz2  # noqa: PLC0415

        decompressor: Any = bz2.BZ2Decompressor()
    else:
        decompressor = _import_lz4().LZ4FrameDecompressor()
    content = BytesIO()  # grows in place, and returns its bytes without copying them
    remaining = size
    # In small pieces, so that little of the data before a damaged part is lost.
    piece_size = _SMALL_PIECE_SIZE if partial else _PIECE_SIZE
    view = memoryview(data)
    try:
        for start in range(0, len(data), piece_size):
            piece = view[start : start + piece_size]
            while remaining > 0:
                output: bytes = decompressor.decompress(piece, min(remaining, _PIECE_SIZE))
                if len(output) == size:
                    return output
                remaining -= content.write(output)
                if decompressor.eof:
                    return content.getvalue()
                if decompressor.needs_input or not output:
                    break
                piece = memoryview(b"")
    except (OSError, RuntimeError, EOFError, ValueError) as error:
        if not partial:
            raise RecordError(f"the chunk's {compression} data are damaged: {error}") from None
    return content.getvalue()


def _import_lz4() -> Any:
    import lz4.frame  # type: ignore[import-untyped]  # noqa: PLC0415 - few bags need it

    return lz4.frame
