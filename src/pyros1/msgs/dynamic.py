"""Creates message classes from the definitions in connection headers and bags (G15).

With these classes, any topic can be read, even if its message package is not installed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.base import Message
from pyros1.msgs.digest import Digests, split_full_text
from pyros1.msgs.factory import make_message_class
from pyros1.msgs.spec import HEADER_TYPE, MessageSpec, is_type_name, parse_message

MAX_TEXT_LENGTH = 1 << 20
"""Maximum length of a full text from a peer, in characters."""

EMPTY_MD5 = "d41d8cd98f00b204e9800998ecf8427e"
"""md5 sum of a message without fields."""

_HEADER_TEXT = "uint32 seq\ntime stamp\nstring frame_id\n"


def from_definition(type_name: str, full_text: str) -> type[Message]:
    """Create a class from a full text.

    Args:
        type_name: full type name of the message, ``package/Type``.
        full_text: the definitions of the message and of all types used, as in the field ``message_definition`` of a
            connection header.

    Returns:
        A new class; its md5 sum is computed from the text.

    Raises:
        DefinitionError: the text is invalid, too long, or lacks a type that is used.
    """
    if len(full_text) > MAX_TEXT_LENGTH:
        raise DefinitionError(
            f"the definition has {len(full_text)} characters; the limit is {MAX_TEXT_LENGTH}", type_name
        )
    cls = from_texts(type_name, split_full_text(type_name, full_text))
    # The peer's text, not one composed here, so that bags and further subscribers receive the same text.
    cls._full_text = full_text
    return cls


def from_texts(
    type_name: str, definitions: Mapping[str, str], find_installed: Callable[[str], MessageSpec] | None = None
) -> type[Message]:
    """Create a class from its definition text and the texts of its nested types.

    Args:
        type_name: full type name of the message.
        definitions: full type name -> definition text.
        find_installed: returns the definition of an installed type, for types that are not in ``definitions``; None if
            ``definitions`` must be complete.

    Raises:
        DefinitionError: a text is invalid, or the text of a type that is used is missing.
        UnknownTypeError: ``find_installed`` does not know a type that is used.
    """
    texts = dict(definitions)
    texts.setdefault(HEADER_TYPE, texts.get("roslib/Header", _HEADER_TEXT))
    specs: dict[str, MessageSpec] = {}
    classes: dict[str, type[Message]] = {}

    def resolve(name: str) -> MessageSpec:
        spec = specs.get(name)
        if spec is None:
            if name in texts:
                spec = parse_message(name, texts[name], f"definition of {type_name}, {name}")
            elif find_installed is not None:
                spec = find_installed(name)
            else:
                raise DefinitionError(f"the definition uses {name}, but its text is missing", type_name)
            specs[name] = spec
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
    return lookup(type_name)
