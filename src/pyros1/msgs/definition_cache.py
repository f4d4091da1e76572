"""A cache of message classes for the connections of a program."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.ground.errors import MessageError
from pyros1.msgs.base import Message


class DefinitionCache:
    """A cache of classes created from definitions, for programs with many connections.

    Args:
        limit: maximum number of classes and errors to keep; the oldest are removed first.
        prefer_installed: see `pyros1.msgs.nonstandard_definitions.find_class`.
    """

    def __init__(self, limit: int = 1000, *, prefer_installed: bool = False) -> None:
        self._limit = limit
        self._prefer_installed = prefer_installed
        self._results: dict[tuple[str, str, str], type[Message] | MessageError] = {}

    def get_cached(self, type_name: str, md5sum: str, full_text: str) -> type[Message] | None:
        """Return the class if `get` has found it before; otherwise None. This never takes long.

        Args:
            type_name, md5sum, full_text: see `get`.
        """
        result = self._results.get((type_name, md5sum, full_text))
        return result if isinstance(result, type) else None

    def get(self, type_name: str, md5sum: str, full_text: str, others: Iterable[str] = ()) -> type[Message]:
        """Return the class for a connection header's ``type``, ``md5sum`` and ``message_definition``.

        If the text is unusable, or its md5 sum is not ``md5sum``, an installed type with the same name and md5 sum is
        used instead. A text with another md5 sum is not an error, since some publishers announce ``*`` or a sum of
        their own.

        Args:
            others: definition texts from other connections with that type, to use if ``full_text`` is unusable.

        Raises:
            DefinitionError: the text is invalid, and nothing can replace it.
            UnknownTypeError: the text is empty, and nothing can replace it.
        """
        key = (type_name, md5sum, full_text)
        others = tuple(others)
        result = self._results.get(key)
        if result is None or (others and isinstance(result, MessageError)):
            from pyros1.msgs.nonstandard_definitions import find_class  # noqa: PLC0415 - most programs never get here

            try:
                result = find_class(type_name, md5sum, full_text, others, prefer_installed=self._prefer_installed)
            except MessageError as error:
                result = error  # cached as well: the search may take a second, and would be repeated for each message
            for oldest in list(self._results)[: max(0, len(self._results) - self._limit + 1)]:
                self._results.pop(oldest, None)
            self._results[key] = result
        if isinstance(result, MessageError):
            raise result.with_traceback(None)  # otherwise each raise would extend the traceback
        return result
