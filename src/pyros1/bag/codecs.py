"""Compression of chunks: none, bz2 and lz4."""

from __future__ import annotations

from typing import Any

from pyros1.bag.records import LimitError, RecordError

COMPRESSIONS = ("none", "bz2", "lz4")

MAX_CHUNK = 1 << 31
"""Largest content of a chunk that is written, in bytes."""


def check_size(size: int, limit: int) -> None:
    """Raise LimitError if a chunk or record claims to hold more bytes than are read."""
    if size > limit:
        raise LimitError(
            f"it claims to hold {size} bytes, and no more than {limit} are read: "
            "--chunk-limit MB raises that limit, if the file can be trusted"
        )


_BZ2_FULL_LEVEL = 9
_LZ4_BLOCKS_OF_1_MB = 6


def compress(compression: str, data: bytes) -> bytes:
    """Return a chunk's content as it is stored; `compression` is one of `COMPRESSIONS`."""
    if compression == "bz2":
        import bz2  # noqa: PLC0415 - most bags need none

        return bz2.compress(data, _BZ2_FULL_LEVEL)
    if compression == "lz4":
        # Stock's readers refuse frames that have a size, no checksum, or blocks that need the ones before them.
        packed: bytes = _lz4().compress(
            data, block_size=_LZ4_BLOCKS_OF_1_MB, block_linked=False, content_checksum=True, store_size=False
        )
        return packed
    return bytes(data)


def decompress(compression: str, data: bytes, size: int, limit: int, *, partial: bool = False) -> bytes:
    """Return a stored chunk's content, at most `size` bytes of it: a damaged chunk cannot fill the memory.

    Args:
        compression: as the chunk says.
        data: as stored.
        size: of the content, as the chunk says.
        limit: most bytes of content.
        partial: the chunk may be cut off or spoilt: return what can be saved.

    Raises:
        RecordError: the compression is unknown, the content is larger than the limit, or the bytes are spoilt.
    """
    if compression not in COMPRESSIONS:
        raise RecordError(f"the chunk's compression {compression[:20]!r} is unknown")
    if partial:
        size = min(size, limit)
    check_size(size, limit)
    content = data if compression == "none" else _unpack(compression, data, size, partial)
    if len(content) != size and not partial:
        raise RecordError(f"the chunk holds {len(content)} bytes instead of {size}")
    return content


def _unpack(compression: str, data: bytes, size: int, partial: bool) -> bytes:
    if compression == "bz2":
        import bz2  # noqa: PLC0415

        unpacker: Any = bz2.BZ2Decompressor()
    else:
        unpacker = _lz4().LZ4FrameDecompressor()
    if not partial:
        try:
            content: bytes = unpacker.decompress(data, size)
        except (OSError, RuntimeError, EOFError, ValueError) as error:
            raise RecordError(f"the chunk's {compression} data are damaged: {error}") from None
        return content
    # In small pieces, so that those before the damage are not lost with it.
    parts: list[bytes] = []
    left = size
    step = 4096
    for start in range(0, len(data), step):
        try:
            parts.append(unpacker.decompress(data[start : start + step], left))
            left -= len(parts[-1])
            while left > 0 and not unpacker.eof and not unpacker.needs_input:
                parts.append(unpacker.decompress(b"", left))
                left -= len(parts[-1])
                if not parts[-1]:
                    break
        except (OSError, RuntimeError, EOFError, ValueError):
            break
        if left <= 0 or unpacker.eof:
            break
    return b"".join(parts)


def _lz4() -> Any:
    import lz4.frame  # type: ignore[import-untyped]  # noqa: PLC0415 - few bags have it

    return lz4.frame
