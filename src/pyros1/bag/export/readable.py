"""Definitions and messages of bags as other programs can read them, which want both to be complete."""

from __future__ import annotations

from pyros1.bag.format.records import Connection
from pyros1.ground.errors import MessageError
from pyros1.msgs import DefinitionCache


class Readable:
    """Mends what stock's publishers would not have sent; see `pyros1.msgs.odd_definitions`."""

    def __init__(self) -> None:
        self._classes = DefinitionCache()

    def definition(self, connection: Connection) -> str:
        """Return the full text of a connection's definition; the text in the bag if nothing better is known."""
        try:
            return self._classes.get(connection.type, connection.md5sum, connection.definition)._full_text
        except MessageError:
            return connection.definition

    def body(self, connection: Connection, data: bytes) -> bytes:
        """Return an encoded message without bytes behind its end.

        Raises:
            MessageError: it cannot be decoded.
        """
        cls = self._classes.get(connection.type, connection.md5sum, connection.definition)
        return cls._encode(cls._decode(data, 0, len(data)))
