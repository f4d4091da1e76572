"""Decodes messages of any type, using the definition from their connection header."""

from __future__ import annotations

from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg, DefinitionCache, Message


class Decoder:
    """Decodes messages of any type, using the definition from their connection header or the installed one.

    Args:
        type_name: the topic's type as registered with the master. As in the stock tools, it is used for all messages
            instead of the type in each publisher's header, unless it is empty or its class is not found.
        prefer_installed: see `pyros1.msgs.nonstandard_definitions.find_class`.
    """

    def __init__(self, type_name: str = "", *, prefer_installed: bool = True) -> None:
        self._cache = DefinitionCache(prefer_installed=prefer_installed)
        self._type_name = type_name

    def message_class(self, raw: AnyMsg) -> type[Message]:
        """Return the class of a raw message.

        Raises:
            DefinitionError, UnknownTypeError: the publisher sent no usable definition, and none is installed.
        """
        name, md5sum, text = _header_fields(raw)
        if self._type_name and self._type_name != name:
            try:
                return self._cache.get(self._type_name, md5sum, text)
            except MessageError:
                pass
        return self._cache.get(name, md5sum, text)

    def cached_class(self, raw: AnyMsg) -> type[Message] | None:
        """Return the class of a raw message if it has been created for an earlier message, else None."""
        return self._cache.get_cached(*_header_fields(raw))

    def decode(self, raw: AnyMsg) -> Message:
        """Return the message that a raw message contains.

        Raises:
            MessageError: the class cannot be found, see `message_class`, or the data is not a message of this class.
        """
        message: Message = self.message_class(raw)._decode(raw._buff, 0, len(raw._buff))
        return message


def _header_fields(raw: AnyMsg) -> tuple[str, str, str]:
    header = raw._connection_header or {}
    return header.get("type", ""), header.get("md5sum", ""), header.get("message_definition", "")
