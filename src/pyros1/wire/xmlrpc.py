"""Converts XML-RPC bodies to Python values and back (http://xmlrpc.com/spec.md; the types of
https://wiki.ros.org/Parameter%20Server).

======================  =======================================
XML-RPC                 Python
======================  =======================================
int, i4, i8             int (written as int, 32 bits signed)
boolean                 bool
double                  float
string, no type         str
base64                  bytes (bytearray, memoryview on writing)
dateTime.iso8601        datetime.datetime
array                   list (tuple on writing)
struct                  dict with str keys
nil                     None (read only: ROS has no null)
======================  =======================================

Received bytes are parsed by defusedxml's expat parser with document types forbidden, so that there are no entities to
expand. A table defines which elements each element can contain. The depth and number of values are limited. Nearly
all messages are plain; these are read by ``xmlrpc_scan``, which is faster and gives the same result.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

from pyros1.ground.errors import ProtocolError, SerializationError, XmlRpcFault
from pyros1.wire.xmlrpc_scan import scan_call, scan_response

MAX_DEPTH: Final = 100
"""Maximum nesting depth of arrays and structs, read or written."""

MAX_VALUES: Final = 1_000_000
"""Maximum number of values, including nested ones, in one body that is read."""

_XML_DECLARATION: Final = "<?xml version='1.0'?>\n"
_MIN_INT: Final = -(2**31)
_MAX_INT: Final = 2**31 - 1


class PreparedList(list[Any]):
    """A list that is sent often but encoded as XML only once. The XML is stored in ``text``; set it to None after
    changing the list.
    """

    __slots__ = ("text",)

    def __init__(self, items: Iterable[Any] = ()) -> None:
        super().__init__(items)
        self.text: str | None = None


class PreparedDict(dict[str, Any]):
    """A dict that is sent often but encoded as XML only once, like `PreparedList`."""

    __slots__ = ("text",)

    def __init__(self, items: Mapping[str, Any] | Iterable[tuple[str, Any]] = ()) -> None:
        super().__init__(items)
        self.text: str | None = None


# --------------------------------------------------------------------------------------------------------------------
# Writing. Every value has an explicit type, and no element is self-closing, as roscpp's parser requires.

_NOT_XML_CHARACTER: Final = (
    "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"  # compiled when needed, since compiling takes 0.5 ms
)


def _escape(text: str) -> str:
    if not text.isprintable():  # `isprintable` is much faster than a search, and nearly always true
        invalid = re.search(_NOT_XML_CHARACTER, text)
        if invalid is not None:
            raise SerializationError(
                f"XML-RPC cannot transmit the character {invalid.group()!r} of the string {text[:40]!r}"
            )
    if "&" in text:
        text = text.replace("&", "&amp;")
    if "<" in text:
        text = text.replace("<", "&lt;")
    if ">" in text:
        text = text.replace(">", "&gt;")
    return text


def _encode_value(value: Any, depth: int) -> str:  # noqa: PLR0911 - one return per kind of value
    """Return the ``<value>`` element of a value."""
    value_class = value.__class__
    if value_class is str:
        return f"<value><string>{_escape(value)}</string></value>"
    if value_class is float:
        return f"<value><double>{value!r}</double></value>"
    if value_class is int and _MIN_INT <= value <= _MAX_INT:
        return f"<value><int>{value}</int></value>"
    if value_class is bool:
        return "<value><boolean>1</boolean></value>" if value else "<value><boolean>0</boolean></value>"
    if value_class is list or value_class is tuple:
        return _encode_array(value, depth)
    if value_class is dict:
        return _encode_struct(value, depth)
    return _encode_uncommon(value, depth)


def _increase_depth(depth: int) -> int:
    if depth >= MAX_DEPTH:
        raise SerializationError(f"a value is nested deeper than {MAX_DEPTH} levels")
    return depth + 1


def _encode_array(value: Sequence[Any], depth: int) -> str:
    depth = _increase_depth(depth)
    items = [
        f"<value><string>{_escape(item)}</string></value>" if item.__class__ is str else _encode_value(item, depth)
        for item in value
    ]
    return f"<value><array><data>{''.join(items)}</data></array></value>"


def _encode_struct(value: dict[Any, Any], depth: int) -> str:
    depth = _increase_depth(depth)
    try:
        names = "".join(value)
    except TypeError:
        invalid = next(key for key in value if not isinstance(key, str))
        raise SerializationError(f"dictionary keys must be strings, not {invalid!r}") from None
    if _escape(names) is not names:  # all names are checked at once: escaping is rare
        value = {_escape(key): item for key, item in value.items()}
    items = [
        f"<member><name>{key}</name><value><double>{item!r}</double></value></member>"
        if item.__class__ is float
        else f"<member><name>{key}</name>{_encode_value(item, depth)}</member>"
        for key, item in value.items()
    ]
    return f"<value><struct>{''.join(items)}</struct></value>"


def _encode_uncommon(value: Any, depth: int) -> str:  # noqa: PLR0911, PLR0912 - one return per kind of value
    """Return the ``<value>`` element of a less common value: a subclass, binary data, a date, or an integer from
    another library.
    """
    if isinstance(value, (PreparedDict, PreparedList)):
        text = value.text
        if text is None:
            text = _encode_struct(value, depth) if isinstance(value, dict) else _encode_array(value, depth)
            value.text = text
        return text
    from datetime import datetime  # noqa: PLC0415 - rarely needed, so not loaded at every start

    if isinstance(value, (bytes, bytearray, memoryview)):
        return "<value><base64>" + binascii.b2a_base64(value, newline=False).decode("ascii") + "</base64></value>"
    if isinstance(value, str):
        return _encode_value(str.__str__(value), depth)
    if isinstance(value, float):
        return _encode_value(float(value), depth)
    if isinstance(value, datetime):
        return f"<value><dateTime.iso8601>{value.year:04d}{value:%m%dT%H:%M:%S}</dateTime.iso8601></value>"
    if isinstance(value, (list, tuple)):
        return _encode_value(list(value), depth)
    if isinstance(value, dict):
        return _encode_struct(value, depth)
    if type(value).__name__ == "Binary" and isinstance(getattr(value, "data", None), bytes):
        # An xmlrpc.client.Binary; the module is not imported, since it loads socket modules.
        return _encode_uncommon(value.data, depth)
    if hasattr(value, "__index__"):
        try:
            number = int(value.__index__())
        except TypeError:  # an array of numbers
            raise SerializationError(
                f"a {type(value).__name__} cannot be sent over XML-RPC: convert it to a list"
            ) from None
        if not _MIN_INT <= number <= _MAX_INT:
            raise SerializationError(f"the integer {number} does not fit into the 32 bits of XML-RPC's integers")
        return _encode_value(number, depth)
    if value is None:
        raise SerializationError("None (null) cannot be sent over XML-RPC")
    raise SerializationError(f"a {type(value).__name__} cannot be sent over XML-RPC")


def dumps_call(method: str, params: Sequence[Any]) -> bytes:
    """Return the XML body of a call.

    Raises:
        SerializationError: a parameter is not of one of the types above, or an int does not fit into 32 bits.
    """
    items = "".join([f"<param>{_encode_value(value, 0)}</param>" for value in params])
    name = f"<methodName>{_escape(method)}</methodName>"
    return f"{_XML_DECLARATION}<methodCall>{name}<params>{items}</params></methodCall>".encode()


def dumps_response(value: Any) -> bytes:
    """Return the XML body of a successful response.

    Raises:
        SerializationError: the value is not of one of the types above, or an int does not fit into 32 bits.
    """
    return (
        f"{_XML_DECLARATION}<methodResponse><params><param>{_encode_value(value, 0)}</param></params></methodResponse>"
    ).encode()


def dumps_fault(code: int, text: str) -> bytes:
    """Return the XML body of a fault; characters that XML cannot represent are replaced, so this never fails."""
    fault = _encode_value({"faultCode": code, "faultString": re.sub(_NOT_XML_CHARACTER, "?", text)}, 0)
    return f"{_XML_DECLARATION}<methodResponse><fault>{fault}</fault></methodResponse>".encode()


# --------------------------------------------------------------------------------------------------------------------
# Reading.


def _read_int(text: str) -> int:
    if len(text) > 32:
        raise ValueError(f"integer of {len(text)} characters")
    number = int(text)
    if not -(2**63) <= number < 2**63:
        raise ValueError(f"integer {number} exceeds 64 bits")
    return number


def _read_boolean(text: str) -> bool:
    text = text.strip()
    if text not in ("0", "1"):
        raise ValueError(f"boolean {text[:40]!r}")
    return text == "1"


def _read_datetime(text: str) -> Any:
    from datetime import datetime  # noqa: PLC0415 - rarely needed, so not loaded at every start

    return datetime.strptime(text.strip(), "%Y%m%dT%H:%M:%S")


def _read_nil(text: str) -> None:
    return None


SCALAR_CONVERTERS: Final[dict[str, Callable[[str], Any]]] = {
    "string": str,
    "int": _read_int,
    "i4": _read_int,
    "i8": _read_int,
    "double": float,
    "boolean": _read_boolean,
    "base64": binascii.a2b_base64,
    "dateTime.iso8601": _read_datetime,
    "nil": _read_nil,
}
_NO_CHILDREN: Final[frozenset[str]] = frozenset()
_CHILDREN: Final[dict[str, frozenset[str]]] = {
    # element -> the elements that it can contain; "" is the document
    "": frozenset({"methodCall", "methodResponse"}),
    "methodCall": frozenset({"methodName", "params"}),
    "methodResponse": frozenset({"params", "fault"}),
    "methodName": _NO_CHILDREN,
    "params": frozenset({"param"}),
    "param": frozenset({"value"}),
    "fault": frozenset({"value"}),
    "value": frozenset({"array", "struct", *SCALAR_CONVERTERS}),
    "array": frozenset({"data"}),
    "data": frozenset({"value"}),
    "struct": frozenset({"member"}),
    "member": frozenset({"name", "value"}),
    "name": _NO_CHILDREN,
    **dict.fromkeys(SCALAR_CONVERTERS, _NO_CHILDREN),
}


class Reader:
    """Builds values from the parser's events.

    Complete values are on ``stack``. ``marks`` contains, for each open array or struct, the index of its first value on
    the stack; in a struct, names and values alternate. ``has_type`` tells whether the innermost open ``<value>``
    already had its type element; without one, its text is the value.
    """

    __slots__ = (
        "fault_count",
        "has_type",
        "marks",
        "method",
        "open_tags",
        "parser",
        "parser_errors",
        "root_tag",
        "stack",
        "text",
        "value_count",
    )

    def __init__(self) -> None:
        # Imported here, since most programs never receive a message that needs the full parser. Other interfaces of
        # defusedxml take 10 ms longer to load.
        from defusedxml.ElementTree import DefusedXMLParser, ParseError  # type: ignore[import-untyped] # noqa: PLC0415

        # ValueError: defusedxml refuses the text, or a number or base64 is invalid; LookupError: unknown XML encoding
        self.parser_errors = (ParseError, ValueError, LookupError)
        self.stack: list[Any] = []
        self.marks: list[int] = []
        self.open_tags: list[str] = [""]
        self.text: list[str] = []
        self.has_type = False
        self.value_count = 0
        self.root_tag = ""
        self.method: str | None = None
        self.fault_count = 0
        self.parser = DefusedXMLParser(forbid_dtd=True)
        expat = self.parser.parser
        # The parser's own handlers build an element tree; here the parser is only used to refuse dangerous XML.
        expat.DefaultHandlerExpand = None
        expat.CommentHandler = None
        expat.ProcessingInstructionHandler = None
        expat.buffer_text = True
        expat.StartElementHandler = self._start
        expat.EndElementHandler = self._end
        expat.CharacterDataHandler = self.text.append

    def read(self, body: bytes) -> None:
        try:
            self.parser.feed(body)
            # Called instead of parser.close(), which would ask the missing tree builder for its tree.
            self.parser.parser.Parse(b"", True)
        except ProtocolError:
            raise
        except (*self.parser_errors, self.parser._error) as error:
            raise ProtocolError(f"not an XML-RPC message: {error}") from error

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        open_tags = self.open_tags
        if tag not in _CHILDREN[open_tags[-1]]:
            raise ProtocolError(f"not an XML-RPC message: <{tag[:40]}> inside <{open_tags[-1]}>")
        if tag == "value":
            self.has_type = False
            self.value_count += 1
            if self.value_count > MAX_VALUES:
                raise ProtocolError(f"XML-RPC message with more than {MAX_VALUES} values")
        elif open_tags[-1] == "value":
            if self.has_type:
                raise ProtocolError("not an XML-RPC message: a <value> contains two values")
            if tag == "struct" or tag == "array":  # noqa: PLR1714 - the hot path: no tuple search
                if len(self.marks) >= MAX_DEPTH:
                    raise ProtocolError(f"XML-RPC value nested deeper than {MAX_DEPTH} levels")
                self.marks.append(len(self.stack))
        open_tags.append(tag)
        self.text.clear()

    def _end(self, tag: str) -> None:
        open_tags = self.open_tags
        open_tags.pop()
        if tag == "value":
            if not self.has_type:
                self.stack.append("".join(self.text))
                self.has_type = True
            if open_tags[-1] == "member" and (len(self.stack) - self.marks[-1]) & 1:
                raise ProtocolError("not an XML-RPC message: a struct member without a name")
        elif tag in SCALAR_CONVERTERS:
            self.stack.append(SCALAR_CONVERTERS[tag]("".join(self.text)))
            self.has_type = True
        elif tag == "name":
            if (len(self.stack) - self.marks[-1]) & 1:
                raise ProtocolError("not an XML-RPC message: a struct member with two names")
            self.stack.append("".join(self.text))
        elif tag == "struct":
            mark = self.marks.pop()
            items = self.stack[mark:]
            self.stack[mark:] = [dict(zip(items[0::2], items[1::2], strict=True))]
            self.has_type = True
        elif tag == "array":
            mark = self.marks.pop()
            self.stack[mark:] = [self.stack[mark:]]
            self.has_type = True
        else:
            self._end_container(tag)
        self.text.clear()

    def _end_container(self, tag: str) -> None:
        if tag == "member":
            if (len(self.stack) - self.marks[-1]) & 1:
                raise ProtocolError("not an XML-RPC message: a struct member without a value")
        elif tag == "methodName":
            self.method = "".join(self.text).strip()
        elif tag == "fault":
            self.fault_count += 1
        elif tag in ("methodCall", "methodResponse"):
            self.root_tag = tag


def loads_call(body: bytes) -> tuple[str, list[Any]]:
    """Read the body of a call.

    Returns:
        The method's name and its parameters.

    Raises:
        ProtocolError: the bytes are not an XML-RPC call, or a limit is exceeded.
    """
    result = scan_call(body, SCALAR_CONVERTERS, MAX_DEPTH, MAX_VALUES)
    if result is not None:
        return result
    reader = Reader()
    reader.read(body)
    if reader.root_tag != "methodCall" or not reader.method:
        raise ProtocolError("not an XML-RPC message: no method is called")
    return reader.method, reader.stack


def loads_response(body: bytes) -> Any:
    """Read the body of a response.

    Returns:
        The value that the response contains.

    Raises:
        XmlRpcFault: the response is a fault.
        ProtocolError: the bytes are not an XML-RPC response, or a limit is exceeded.
    """
    result = scan_response(body, SCALAR_CONVERTERS, MAX_DEPTH, MAX_VALUES)
    if result is not None:
        return result[0]
    reader = Reader()
    reader.read(body)
    if reader.root_tag != "methodResponse" or len(reader.stack) != 1:
        raise ProtocolError("not an XML-RPC message: a response must contain exactly one value")
    value = reader.stack[0]
    if not reader.fault_count:
        return value
    code = value.get("faultCode") if isinstance(value, dict) else None
    text = value.get("faultString") if isinstance(value, dict) else None
    if code is None or text is None:
        raise ProtocolError("not an XML-RPC message: a fault without faultCode and faultString")
    if not isinstance(code, int):  # some servers send strings
        code, text = 0, f"{code}: {text}"
    raise XmlRpcFault(code, str(text))
