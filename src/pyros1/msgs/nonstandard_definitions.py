"""Classes for connections whose definition text is not what stock's publishers send.

Other client libraries send texts without the nested types, cut, empty, with other separators or line ends. The md5 sum
of the connection says whether a reading of such a text is right. What is missing or unreadable comes from the
definitions that are installed here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from pyros1.ground import generated
from pyros1.ground.errors import DefinitionError, Error, MessageError, UnknownTypeError
from pyros1.msgs.base import Message
from pyros1.msgs.dynamic import EMPTY_MD5, MAX_TEXT, from_definition, from_texts
from pyros1.msgs.spec import MessageSpec, is_type_name

_T = TypeVar("_T")

ANY = "*"
_MAX_TYPES = 100
"""Maximum number of types in a leniently read text: a search for one that is not installed takes over a millisecond."""
# Of lines without blanks at their ends: two parts that both match blanks would take quadratic time.
_SEPARATOR = re.compile(r"[=-]{10,}\Z")
_TITLE = re.compile(r"(?:MSG\s*:\s*)?(\w+/(?:msg/)?\w+)\Z", re.IGNORECASE)
_BLANKS = re.compile(r"[\t\v\f\xa0\ufeff]")


def find_class(
    type_name: str, md5sum: str, full_text: str, others: Iterable[str] = (), *, by_name: bool = False
) -> type[Message]:
    """Return the class for messages of a connection.

    These are tried in turn; the first whose md5 is that of the connection is used:

    1. the text as it is,
    2. the type of that name that is installed here,
    3. the text read leniently, with nested types that are installed here,
    4. other texts of that type.

    If none has it, the text as it is counts if it is a definition, since some publishers send ``*`` or their own sums;
    but if ``*`` comes with only the beginning of the definition that is installed here, this one counts.

    Args:
        type_name: full type name.
        md5sum: md5 sum from the connection header; ``*`` or nothing if it is unknown.
        full_text: its definition text, perhaps empty.
        others: definition texts of other connections with that type.
        by_name: whether an installed type of that name counts more than a text with another md5 than the connection's,
            as for stock's tools, which know only installed types.

    Raises:
        DefinitionError: the text is wrong, and nothing else can replace it.
        UnknownTypeError: there is no text, and nothing else can replace it.
    """
    md5sum = md5sum.strip().lower()
    unknown = md5sum in (ANY, "")
    wrong: MessageError | None = None
    from_text = None
    if full_text.strip() or unknown or md5sum == EMPTY_MD5:
        from_text, wrong = _or_error(lambda: from_definition(type_name, full_text))
    if from_text is not None and from_text._md5sum == md5sum:
        return from_text
    installed, _ = _or_error(lambda: _installed(type_name))
    if installed is not None and installed._md5sum == md5sum:
        return installed
    if from_text is None or not unknown:
        for text in (full_text, *others):
            for read in _interpretations(type_name, text):
                if read._md5sum == md5sum or (unknown and installed is None):
                    return read
    if installed is not None and (by_name or (unknown and (from_text is None or _is_prefix(from_text, installed)))):
        return installed
    if from_text is not None:
        return from_text
    if not full_text.strip():
        other = "" if installed is None else ", and the one installed here has another md5 sum"
        raise UnknownTypeError(f"the publisher of type {type_name} sent no definition{other}")
    assert wrong is not None
    raise wrong


def _installed(type_name: str) -> type[Message] | None:
    finder = generated.finder()
    if finder.library.find_message(type_name) is None:
        return None
    made: type[Message] = finder.message(type_name)
    return made


def _or_error(make: Callable[[], _T]) -> tuple[_T | None, MessageError | None]:
    try:
        return make(), None
    except MessageError as error:
        return None, error
    except Error as error:
        return None, DefinitionError(str(error))


def _is_prefix(cls: type[Message], whole: type[Message]) -> bool:
    """Return whether the fields of a class are the first ones of another, perhaps with the last name cut off."""
    names, kinds = list(cls.__slots__), cls._slot_types
    count = len(names)
    if kinds != whole._slot_types[:count]:
        return False
    last = names.pop() if names else ""
    return names == list(whole.__slots__[: len(names)]) and (not last or whole.__slots__[count - 1].startswith(last))


def _interpretations(type_name: str, full_text: str) -> Iterator[type[Message]]:
    """Yield the classes that a text with odd separators, titles, blanks or line ends may stand for.

    Nested types that it lacks are those installed here; then those that it has, too, since it may be cut off there.
    """
    if len(full_text) > MAX_TEXT:
        return
    texts = _split(type_name, full_text)
    if len(texts) > _MAX_TYPES:
        return
    own = {name: text for name, text in texts.items() if name == type_name or _or_error(lambda: _spec(name))[0] is None}  # noqa: B023 - called at once
    for each in (texts, own):
        cls, _ = _or_error(lambda: from_texts(type_name, each, _spec))  # noqa: B023 - called at once
        if cls is not None:
            yield cls


def _spec(name: str) -> MessageSpec:
    """Return the definition of an installed type."""
    spec: MessageSpec | None = generated.finder().library.find_message(name)
    if spec is None:
        raise UnknownTypeError(f"message type [{name}] is unknown")
    return spec


def _split(type_name: str, full_text: str) -> dict[str, str]:
    """Split a text into definitions, at lines of ``=`` or ``-`` of any length, and at ``MSG:`` lines without one."""
    texts: dict[str, list[str]] = {type_name: []}
    current: str | None = type_name
    titled = True
    for line in map(str.strip, _BLANKS.sub(" ", full_text).splitlines()):
        if _SEPARATOR.match(line):
            current, titled = None, False
            continue
        title = _TITLE.match(line)
        if title and (not titled or line.upper().startswith("MSG")):
            name = title[1].replace("/msg/", "/", 1)
            current, titled = name, True
            if name in texts and name != type_name:
                current = None  # the first one counts
            elif is_type_name(name):
                texts.setdefault(name, [])
            else:
                current = None
            continue
        if line:
            titled = True
        if current is not None:
            texts[current].append(line)
    return {name: "\n".join(lines) for name, lines in texts.items()}
