"""Message classes from definitions in connection headers and bags (G15).

With these, any topic can be read, even if its message package is not on this machine.
"""

from __future__ import annotations

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs.base import Message
from pyros1.msgs.digest import Digests, split_full_text
from pyros1.msgs.factory import make_message_class
from pyros1.msgs.spec import HEADER, MessageSpec, is_type_name, parse_message

MAX_TEXT = 1 << 20
"""Longest full text that is accepted from a peer, in characters."""

_HEADER_TEXT = "uint32 seq\ntime stamp\nstring frame_id\n"


def from_definition(type_name: str, full_text: str) -> type[Message]:
    """Return a class made from a full text.

    Args:
        type_name: full type name of the message, ``package/Type``.
        full_text: its definition and those of all types used (``message_definition`` of a connection header).

    Returns:
        A new class; its md5 is computed from the text.

    Raises:
        DefinitionError: the text is wrong, too long, or lacks a type that is used.
    """
    if len(full_text) > MAX_TEXT:
        raise DefinitionError(f"the definition has {len(full_text)} characters; the limit is {MAX_TEXT}", type_name)
    texts = split_full_text(type_name, full_text)
    texts.setdefault(HEADER, texts.get("roslib/Header", _HEADER_TEXT))
    specs: dict[str, MessageSpec] = {}
    classes: dict[str, type[Message]] = {}

    def resolve(name: str) -> MessageSpec:
        spec = specs.get(name)
        if spec is None:
            if name not in texts:
                raise DefinitionError(f"the definition uses {name}, but its text is missing", type_name)
            spec = specs[name] = parse_message(name, texts[name], f"definition of {type_name}, {name}")
        return spec

    digests = Digests(resolve)

    def lookup(name: str) -> type[Message]:
        cls = classes.get(name)
        if cls is None:
            cls = classes[name] = make_message_class(
                resolve(name), digests, lookup, f"{__name__}.{name.split('/', maxsplit=1)[0]}"
            )
        return cls

    if not is_type_name(type_name):
        raise DefinitionError(f"[{type_name}] is not a type name of the form package/Type")
    cls = lookup(type_name)
    # The text of the peer, not one composed here, so that bags and further subscribers get the same text.
    cls._full_text = full_text
    return cls


class DefinitionCache:
    """Cache of classes made from definitions, for programs with many connections.

    Args:
        limit: most classes to keep; the oldest are removed first.
    """

    def __init__(self, limit: int = 1000) -> None:
        self._limit = limit
        self._classes: dict[tuple[str, str, str], type[Message]] = {}

    def get(self, type_name: str, md5sum: str, full_text: str) -> type[Message]:
        """Return the class for a connection header's ``type``, ``md5sum`` and ``message_definition``.

        Raises:
            DefinitionError: the text is wrong. It is not an error if its md5 differs from ``md5sum``: some
                publishers announce ``*`` or their own sums, and only the text matters for decoding.
            UnknownTypeError: the peer sent no definition.
        """
        key = (type_name, md5sum, full_text)
        cls = self._classes.get(key)
        if cls is None:
            if not full_text.strip() and md5sum not in ("*", EMPTY_MD5):
                raise UnknownTypeError(f"the publisher of type {type_name} sent no definition")
            cls = from_definition(type_name, full_text)
            for oldest in list(self._classes)[: max(0, len(self._classes) - self._limit + 1)]:
                self._classes.pop(oldest, None)
            self._classes[key] = cls
        return cls


EMPTY_MD5 = "d41d8cd98f00b204e9800998ecf8427e"
"""md5 of a message without fields."""
