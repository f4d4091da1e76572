"""A cache of message classes for the connections of a program."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.ground.errors import MessageError
from pyros1.msgs.base import Message


class DefinitionCache:
    """Cache of classes made from definitions, for programs with many connections.

    Args:
        limit: maximum number of classes and errors to keep; the oldest are removed first.
        by_name: see `pyros1.msgs.nonstandard_definitions.find_class`.
    """

    def __init__(self, limit: int = 1000, *, by_name: bool = False) -> None:
        self._limit = limit
        self._by_name = by_name
        self._found: dict[tuple[str, str, str], type[Message] | MessageError] = {}

    def get(self, type_name: str, md5sum: str, full_text: str, others: Iterable[str] = ()) -> type[Message]:
        """Return the class for a connection header's ``type``, ``md5sum`` and ``message_definition``.

        If the text is not usable, or its md5 is not ``md5sum``, an installed type of the same name and md5 takes its
        place. It is no error if nothing has that md5: some publishers announce ``*`` or their own sums.

        Args:
            others: definition texts of other connections with that type, perhaps usable ones.

        Raises:
            DefinitionError: the text is wrong, and nothing can replace it.
            UnknownTypeError: the peer sent no definition, and nothing can replace it.
        """
        key = (type_name, md5sum, full_text)
        others = tuple(others)
        found = self._found.get(key)
        if found is None or (others and isinstance(found, MessageError)):
            from pyros1.msgs.nonstandard_definitions import find_class  # noqa: PLC0415 - most programs need no cache's class

            try:
                found = find_class(type_name, md5sum, full_text, others, by_name=self._by_name)
            except MessageError as error:  # also kept: the search may take a second, and each message asks for it
                found = error
            for oldest in list(self._found)[: max(0, len(self._found) - self._limit + 1)]:
                self._found.pop(oldest, None)
            self._found[key] = found
        if isinstance(found, MessageError):
            raise found.with_traceback(None)  # else each raise would make it longer
        return found
