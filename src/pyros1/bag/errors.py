"""Errors about bag files; every message names the file and, if known, the position, and says what to do."""

from __future__ import annotations

from pyros1.ground.errors import Error


class BagError(Error):
    """A bag file cannot be read or written.

    Args:
        path: path of the bag file.
        reason: what is wrong and what to do.
        offset: byte offset of the invalid record; None if the error concerns the whole file.
    """

    def __init__(self, path: str, reason: str, offset: int | None = None) -> None:
        self.path = path
        self.reason = reason
        self.offset = offset
        super().__init__(f"{path}: {reason}" if offset is None else f"{path}: at byte {offset}: {reason}")


class NotABagError(BagError):
    """The file is empty, not a bag, or of a version that is not supported."""


class UnindexedError(BagError):
    """The bag was not closed, or its index is damaged: ``pyros1 bag reindex`` can repair it."""


class EncryptedError(BagError):
    """The bag is encrypted."""
