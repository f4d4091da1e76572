"""Finds classes for connections whose definition text differs from what stock's publishers send.

Other client libraries send texts without nested types, truncated or empty texts, or texts with other separators or line
endings. An interpretation of such a text is right if it has the connection's md5 sum. Missing or unreadable parts are
taken from the installed definitions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from pyros1.ground import msgs_imports
from pyros1.ground.errors import DefinitionError, Error, MessageError, UnknownTypeError
from pyros1.msgs.base import Message
from pyros1.msgs.dynamic import EMPTY_MD5, MAX_TEXT_LENGTH, from_definition, from_texts
from pyros1.msgs.spec import MessageSpec, is_type_name

_T = TypeVar("_T")

_ANY_MD5SUM = "*"
_MAX_TYPES = 100
"""Maximum number of types in a leniently parsed text, since searching for one that is not installed takes over a
millisecond.
"""
# Used on lines without surrounding blanks: two parts that both match blanks would take quadratic time.
_SEPARATOR_PATTERN = re.compile(r"[=-]{10,}\Z")
_TITLE_PATTERN = re.compile(r"(?:MSG\s*:\s*)?(\w+/(?:msg/)?\w+)\Z", re.IGNORECASE)
_BLANKS_PATTERN = re.compile(r"[\t\v\f\xa0\ufeff]")


def find_class(
    type_name: str, md5sum: str, full_text: str, other_texts: Iterable[str] = (), *, prefer_installed: bool = False
) -> type[Message]:
    """Return the class for the messages of a connection.

    These are tried in order; the first one with the md5 sum of the connection is used:

    1. the text, unchanged,
    2. the installed type with that name,
    3. the text, parsed leniently and completed with installed nested types,
    4. the other texts for that type.

    If none has that md5 sum, the unchanged text is used if it is valid, since some publishers send ``*`` or their own
    kind of sum. But if the sum is ``*`` and the text is only the beginning of the installed definition, the installed
    type is used.

    Args:
        type_name: full type name.
        md5sum: md5 sum from the connection header; ``*`` or empty if unknown.
        full_text: the connection's definition text, which may be empty.
        other_texts: definition texts from other connections with that type.
        prefer_installed: whether to prefer an installed type of that name to a text whose md5 sum differs from the
            connection's, like stock's tools, which only know installed types.

    Raises:
        DefinitionError: the text is invalid, and nothing can replace it.
        UnknownTypeError: there is no text, and nothing can replace it.
    """
    md5sum = md5sum.strip().lower()
    is_unknown = md5sum in (_ANY_MD5SUM, "")
    error: MessageError | None = None
    text_class = None
    if full_text.strip() or is_unknown or md5sum == EMPTY_MD5:
        text_class, error = _try_make(lambda: from_definition(type_name, full_text))
    if text_class is not None and text_class._md5sum == md5sum:
        return text_class
    installed_class, _ = _try_make(lambda: _installed_class(type_name))
    if installed_class is not None and installed_class._md5sum == md5sum:
        return installed_class
    if text_class is None or not is_unknown:
        for text in (full_text, *other_texts):
            for candidate in _interpretations(type_name, text):
                if candidate._md5sum == md5sum or (is_unknown and installed_class is None):
                    return candidate
    if installed_class is not None and (
        prefer_installed or (is_unknown and (text_class is None or _is_prefix(text_class, installed_class)))
    ):
        return installed_class
    if text_class is not None:
        return text_class
    if not full_text.strip():
        mismatch = "" if installed_class is None else ", and the installed one has another md5 sum"
        raise UnknownTypeError(f"the publisher of type {type_name} sent no definition{mismatch}")
    assert error is not None
    raise error


def _installed_class(type_name: str) -> type[Message] | None:
    finder = msgs_imports.finder()
    if finder.library.find_message(type_name) is None:
        return None
    cls: type[Message] = finder.message(type_name)
    return cls


def _try_make(function: Callable[[], _T]) -> tuple[_T | None, MessageError | None]:
    try:
        return function(), None
    except MessageError as error:
        return None, error
    except Error as error:
        return None, DefinitionError(str(error))


def _is_prefix(cls: type[Message], other: type[Message]) -> bool:
    """Return whether the fields of a class are the first fields of another class, possibly with the last name
    truncated.
    """
    names, slot_types = list(cls.__slots__), cls._slot_types
    count = len(names)
    if slot_types != other._slot_types[:count]:
        return False
    last_name = names.pop() if names else ""
    return names == list(other.__slots__[: len(names)]) and (
        not last_name or other.__slots__[count - 1].startswith(last_name)
    )


def _interpretations(type_name: str, full_text: str) -> Iterator[type[Message]]:
    """Yield candidate classes for a definition with nonstandard separators, ``MSG:`` lines, whitespace or line endings.

    The first candidate uses installed packages only for nested types that the text lacks. The second uses them for all
    nested types that are installed, since the text may be truncated.
    """
    if len(full_text) > MAX_TEXT_LENGTH:
        return
    texts = _split(type_name, full_text)
    if len(texts) > _MAX_TYPES:
        return
    required_texts = {
        name: text
        for name, text in texts.items()
        if name == type_name or _try_make(lambda: _installed_spec(name))[0] is None  # noqa: B023 - called at once
    }
    for definitions in (texts, required_texts):
        cls, _ = _try_make(lambda: from_texts(type_name, definitions, _installed_spec))  # noqa: B023 - called at once
        if cls is not None:
            yield cls


def _installed_spec(name: str) -> MessageSpec:
    """Return the definition of an installed type."""
    spec: MessageSpec | None = msgs_imports.finder().library.find_message(name)
    if spec is None:
        raise UnknownTypeError(f"message type [{name}] is unknown")
    return spec


def _split(type_name: str, full_text: str) -> dict[str, str]:
    """Split a text into definitions at lines of at least ten ``=`` or ``-``, or at ``MSG:`` lines that do not follow
    such a line.
    """
    texts: dict[str, list[str]] = {type_name: []}
    current_name: str | None = type_name
    has_title = True
    for line in map(str.strip, _BLANKS_PATTERN.sub(" ", full_text).splitlines()):
        if _SEPARATOR_PATTERN.match(line):
            current_name, has_title = None, False
            continue
        title = _TITLE_PATTERN.match(line)
        if title and (not has_title or line.upper().startswith("MSG")):
            name = title[1].replace("/msg/", "/", 1)
            current_name, has_title = name, True
            if name in texts and name != type_name:
                current_name = None  # the first definition of a type is used
            elif is_type_name(name):
                texts.setdefault(name, [])
            else:
                current_name = None
            continue
        if line:
            has_title = True
        if current_name is not None:
            texts[current_name].append(line)
    return {name: "\n".join(lines) for name, lines in texts.items()}
