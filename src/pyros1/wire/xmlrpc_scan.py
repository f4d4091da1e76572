"""A fast reader for the plain XML-RPC that ROS programs write, several times faster than an event-driven parser.

It knows one token: a ``<value>`` with its scalar, or with the start of an array or struct, together with the
``<member>`` or ``<param>`` around it. It supports no document types, no entities except for XML's five, no comments,
attributes, processing instructions or CDATA, so there is nothing to attack. If it encounters anything else, it gives up
and returns None; the caller then uses the full parser, which decides what is allowed. For any text that it accepts, it
returns the same result as the full parser.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final

_TOKEN: Final = re.compile(
    r"""[ \t\n]*
    (?: <member>[ \t\n]*<name>([^<]*)</name>[ \t\n]* | (<param>)[ \t\n]* )?
    (?: <value>
        (?: [ \t\n]*<(string|int|i4|double|boolean)>([^<]*)</\3>[ \t\n]*</value>
          | ([^<]*)</value>
          | [ \t\n]*<(?:(array)>[ \t\n]*<data>|(struct)>)
        )
      | (</data>[ \t\n]*</array>|</struct>)[ \t\n]*</value>
    )
    (?: [ \t\n]*(</member>|</param>) )?
    """,
    re.VERBOSE,
)
_MEMBER: Final = re.compile(
    r"""[ \t\n]*<member>[ \t\n]*<name>([^<&]*)</name>[ \t\n]*
    <value>[ \t\n]*<(string|int|i4|double|boolean)>([^<&]*)</\2>[ \t\n]*</value>[ \t\n]*</member>""",
    re.VERBOSE,
)
"""Matches a plain member; large structs consist mostly of plain members. `_TOKEN` would match them, too."""
_HEAD: Final = r"(?:<\?xml[ ]version=['\"]1\.0['\"](?:[ ]encoding=['\"](?i:utf-8)['\"])?[ ]?\?>)?[ \t\n]*"
_CALL_HEAD: Final = re.compile(_HEAD + r"<methodCall>[ \t\n]*<methodName>([^<&]*)</methodName>[ \t\n]*<params>")
_CALL_END: Final = re.compile(r"[ \t\n]*</params>[ \t\n]*</methodCall>[ \t\n]*\Z")
_RESPONSE_HEAD: Final = re.compile(_HEAD + r"<methodResponse>[ \t\n]*<params>")
_RESPONSE_END: Final = re.compile(r"[ \t\n]*</params>[ \t\n]*</methodResponse>[ \t\n]*\Z")
_FORBIDDEN_BYTES: Final = bytes([*range(9), 11, 12, *range(14, 32)])

Converters = Mapping[str, Callable[[str], Any]]


class _NotPlain(Exception):
    """The text needs the full parser."""


def _decode(body: bytes) -> str:
    """Return a document as text with normalised line endings; raise _NotPlain if it contains characters that XML
    forbids.
    """
    if len(body.translate(None, _FORBIDDEN_BYTES)) != len(body) or b"\xef\xbf" in body or b"]]>" in body:
        raise _NotPlain
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError:
        raise _NotPlain from None
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text


def _unescape(text: str) -> str:
    text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", '"').replace("&apos;", "'")
    if text.count("&") != text.count("&amp;"):
        raise _NotPlain
    return text.replace("&amp;", "&")


def _read_plain_members(text: str, position: int, converters: Converters, target: dict[str, Any]) -> tuple[int, int]:
    """Read the plain ``<member>`` elements at a position into ``target``; return their number and the position after
    them.
    """
    match = _MEMBER.match
    count = 0
    while (member := match(text, position)) is not None:
        name, type_tag, scalar_text = member.groups()
        target[name] = converters[type_tag](scalar_text)
        position = member.end()
        count += 1
    return count, position


def _read_values(  # noqa: PLR0912, PLR0915 - a tokenizer's loop; calls in it would double its time
    text: str, position: int, converters: Converters, max_depth: int, max_values: int
) -> tuple[list[Any], int]:
    """Return the values of all ``<param>`` elements from a position on, and the position after them."""
    match = _TOKEN.match
    params: list[Any] = []
    # The innermost open array or struct (at first the list of parameters), and those around it.
    current: Any = params
    in_struct = False
    enclosing: list[tuple[Any, str | None]] = []
    value_count = 0
    while True:
        if in_struct:
            count, position = _read_plain_members(text, position, converters, current)
            value_count += count
        token = match(text, position)
        if token is None:
            break
        position = token.end()
        name, param_tag, type_tag, scalar_text, untyped_text, _array_tag, struct_tag, end_tag, closing_tag = (
            token.groups()
        )
        if end_tag is not None:
            if name is not None or param_tag is not None or not enclosing or (end_tag == "</struct>") is not in_struct:
                raise _NotPlain
            value = current
            current, name = enclosing.pop()
            in_struct = name is not None
        else:
            value_count += 1
            if in_struct:
                if name is None:
                    raise _NotPlain
                if "&" in name:
                    name = _unescape(name)
            elif name is not None or (param_tag is None) is not bool(enclosing):
                raise _NotPlain
            if type_tag is not None:
                value = converters[type_tag](_unescape(scalar_text) if "&" in scalar_text else scalar_text)
            elif untyped_text is not None:
                value = _unescape(untyped_text) if "&" in untyped_text else untyped_text
            else:
                if closing_tag is not None or len(enclosing) >= max_depth or value_count > max_values:
                    raise _NotPlain
                enclosing.append((current, name))
                in_struct = struct_tag is not None
                current = {} if in_struct else []
                continue
        if in_struct:
            if closing_tag != "</member>":
                raise _NotPlain
            current[name] = value
        else:
            if closing_tag != (None if enclosing else "</param>"):
                raise _NotPlain
            current.append(value)
    if enclosing or value_count > max_values:
        raise _NotPlain
    return params, position


def scan_call(body: bytes, converters: Converters, max_depth: int, max_values: int) -> tuple[str, list[Any]] | None:
    """Read a call; return its method and parameters, or None if it is invalid or needs the full parser.

    Args:
        converters: name of a type element -> function that converts its text.
        max_depth: maximum nesting depth.
        max_values: maximum number of values.
    """
    try:
        text = _decode(body)
        head = _CALL_HEAD.match(text)
        if head is None:
            return None
        params, position = _read_values(text, head.end(), converters, max_depth, max_values)
        method: str = head.group(1).strip()
        return (method, params) if method and _CALL_END.match(text, position) else None
    except (_NotPlain, ValueError):
        return None


def scan_response(body: bytes, converters: Converters, max_depth: int, max_values: int) -> list[Any] | None:
    """Read a response; return a list with its value, or None if it is a fault or needs the full parser."""
    try:
        text = _decode(body)
        head = _RESPONSE_HEAD.match(text)
        if head is None:
            return None
        params, position = _read_values(text, head.end(), converters, max_depth, max_values)
        return params if len(params) == 1 and _RESPONSE_END.match(text, position) else None
    except (_NotPlain, ValueError):
        return None
