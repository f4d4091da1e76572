"""Messages of topics of any type: the definition comes with their connection."""

from __future__ import annotations

from pyros1.ground.errors import UnknownTypeError
from pyros1.msgs import AnyMsg, DefinitionCache, Message, load_message


class Decoder:
    """Decodes messages of any type, with the definition in their connection's header."""

    def __init__(self) -> None:
        self._cache = DefinitionCache()

    def message_class(self, raw: AnyMsg) -> type[Message]:
        """Return the class of a raw message.

        Raises:
            DefinitionError, UnknownTypeError: the publisher sent no usable definition, and none is installed here.
        """
        header = raw._connection_header or {}
        type_name, md5sum = header.get("type", ""), header.get("md5sum", "")
        try:
            return self._cache.get(type_name, md5sum, header.get("message_definition", ""))
        except UnknownTypeError:
            cls = load_message(type_name)
            if md5sum not in ("*", cls._md5sum):
                raise
            return cls

    def decode(self, raw: AnyMsg) -> Message:
        """Return the decoded message.

        Raises:
            MessageError: see `message_class`, or the bytes are not such a message.
        """
        message: Message = self.message_class(raw)._decode(raw._buff, 0, len(raw._buff))
        return message
