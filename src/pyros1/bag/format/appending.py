"""Appends messages to bags that have been closed."""

from __future__ import annotations

import os
from typing import IO

from pyros1.bag.errors import BagError
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import CHUNK_THRESHOLD, BagWriter, ExistingBag


def open_for_append(
    target: str | os.PathLike[str] | IO[bytes], compression: str = "none", chunk_threshold: int = CHUNK_THRESHOLD
) -> BagWriter:
    """Return a writer that appends chunks to a bag. An encrypted bag stays encrypted.

    Until the writer is closed, the bag has no index, like a new bag.

    Args:
        target, compression, chunk_threshold: as for `BagWriter`.

    Raises:
        UnindexedError: the bag was not closed, or its index is damaged.
        BagError: the file is not a bag, has version 1.2, or cannot be decrypted.
        OSError: the file cannot be read or written.
    """
    with BagReader(target) as reader:
        if reader.file.version != 200:
            raise BagError(
                reader.path, "messages cannot be added to a bag of version 1.2; `pyros1 bag fix` converts it"
            )
        existing = ExistingBag(reader.connections, reader.chunks, reader.file.index_pos)
        cipher = reader.file.cipher
    return BagWriter(target, compression, chunk_threshold, cipher, existing)
