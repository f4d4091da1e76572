"""Base classes of all messages and services, with the interface that programs know from genpy (G15-G25).

A message class has no code of its own. Its constructor and codec functions are generated from the field list when they
are first asked for, so that making a class costs little and an unused direction costs nothing:

* ``cls.__init__``: defaults, positional or keyword arguments;
* ``cls._encode_frame(msg)``: the TCPROS frame, u32 little-endian length and body, as one bytes object, or as a list of
  buffers when it holds large arrays, which are then not copied;
* ``cls._encode(msg)``: the body only;
* ``cls._decode(buffer, start, end, exact=False)``: a message from ``buffer[start:end]``, which must be bytes; if
  ``exact`` is true, bytes behind the message, or a last string that is cut off, raise LengthError: else, as in stock,
  they do not matter;
* ``cls._read(buffer, start, end)``: a message from the beginning of ``buffer[start:end]`` and the offset behind it;
* ``cls._decode_arrays(buffer, start, end, view, exact=False)``, ``cls._read_arrays(...)``: the same, but numeric arrays
  are made by ``view(buffer, position, count, struct_code)``, see ``array_views.py``;
* ``cls._copy(msg)``: the message that encoding and decoding would give, without either of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from pyros1.ground import lazy
from pyros1.ground.errors import DefinitionError, MessageError, SerializationError

if TYPE_CHECKING:
    from pyros1.msgs.digest import Digests
    from pyros1.msgs.spec import MessageSpec

Buffer = bytes | bytearray | memoryview
Frame = bytes | list[bytes | memoryview]
View = Callable[[bytes, int, int, str], Any]
"""Makes a numeric array of (buffer, position, number of elements, struct code)."""
_M = TypeVar("_M", bound="Message")

_GENERATORS = {
    "_encode_frame": "encoder",
    "_encode": "encoder",
    "_decode": "decoder",
    "_read": "decoder",
    "_decode_arrays": "decoder",
    "_read_arrays": "decoder",
    "_copy": "copier",
}
"""The modules that generate functions."""
_COMPUTED_ATTRIBUTES = frozenset({"_classes", "_fixed_size", "_min_size", "_weight"})
"""What classes that genpy has generated lack, see ``foreign.py``."""


def _module(name: str) -> Any:
    """Return a module, imported late: it needs this one, and most messages are never encoded, checked or printed."""
    return lazy.module("pyros1.msgs." + name)


class Array(Protocol):
    """Value of an array field of numbers: a list, a tuple, bytes, an array of numpy or of the standard library."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Any]: ...
    def __getitem__(self, index: int, /) -> Any: ...


class Writable(Protocol):
    """A writable binary file, for :meth:`Message.serialize`."""

    def write(self, data: bytes, /) -> object:
        """Take the bytes."""


class MessageType(type):
    """Type of message classes: generates a codec function when it is first looked up on the class."""

    def __init__(cls, name: str, bases: tuple[type, ...], members: dict[str, Any]) -> None:
        super().__init__(name, bases, members)
        if any("_slot_types" in vars(base) for base in cls.__mro__[1:]):
            _module("derived").derive(cls)

    def __getattr__(cls, name: str) -> Any:
        if name not in _COMPUTED_ATTRIBUTES and name not in _GENERATORS:
            raise AttributeError(f"type object '{cls.__name__}' has no attribute '{name}'")
        try:
            owner = message_class(cls)
        except MessageError as error:  # `help()` asks the base class for the names of each message class
            raise AttributeError(str(error)) from None
        if name in _COMPUTED_ATTRIBUTES:
            if owner is not cls or name not in vars(owner):
                _module("genpy_classes").adopt(owner)
                return getattr(owner, name)
            raise AttributeError(f"type object '{cls.__name__}' has no attribute '{name}'")
        function = staticmethod(getattr(_module(_GENERATORS[name]), "make" + name)(owner))
        setattr(owner, name, function)
        return function.__func__


class _FullText:
    """The class attribute ``_full_text``, which is composed when it is first read.

    For most nested types it is never read, and each text contains the texts of all types used.
    """

    def __get__(self, message: object, owner: type[Any]) -> str:
        if not hasattr(owner, "_text_source"):
            raise AttributeError(f"{owner.__name__} has no definition")
        cls = message_class(owner)
        digests, spec = cls._text_source
        cls._full_text = text = digests.full_text(spec)
        return text


class Message(metaclass=MessageType):
    """Base of all message classes. Messages of itself, and of classes without a definition, are empty.

    Class attributes:
        _type: full type name. _md5sum, _full_text: as in connection headers.
        _slot_types: type of each field, in the order of ``__slots__``.
        _has_header: whether the first field is a header whose ``seq`` publishers set.
        _fixed_size: size of the encoded body in bytes if it is always the same, else None.
        _wants_whole: whether a program has derived the class, with a ``deserialize`` that gets all bytes.

    Args:
        *args: all fields in order, or nothing.
        **kwds: any fields by name; not together with positional ones. None stands for a field's default.

    Raises:
        TypeError: wrong number of arguments, or both kinds.
        AttributeError: no such field.
    """

    __slots__ = ("_connection_header",)

    _type: ClassVar[str]
    _md5sum: ClassVar[str]
    _full_text: ClassVar[str] = _FullText()  # type: ignore[assignment]  # a descriptor
    _text_source: ClassVar[tuple[Digests, MessageSpec]]
    _has_header: ClassVar[bool] = False
    _wants_whole: ClassVar[bool] = False
    _slot_types: ClassVar[list[str]]
    _fixed_size: ClassVar[int | None]
    _min_size: ClassVar[int]
    _weight: ClassVar[int]
    _classes: ClassVar[dict[str, type[Message]]]
    _encode_frame: ClassVar[Callable[[Any], Frame]]
    _encode: ClassVar[Callable[[Any], bytes]]
    _decode: ClassVar[Callable[..., Any]]
    _read: ClassVar[Callable[[bytes, int, int], tuple[Any, int]]]
    _decode_arrays: ClassVar[Callable[..., Any]]
    _read_arrays: ClassVar[Callable[[bytes, int, int, View], tuple[Any, int]]]
    _copy: ClassVar[Callable[[Any], Any]]

    _connection_header: dict[str, str] | None

    def __init__(self, *args: Any, **kwds: Any) -> None:
        if not _is_generated(type(self)):
            _module("constructor").set_all(self, *args, **kwds)
            return
        cls = message_class(type(self))
        cls.__init__ = _module("constructor").make_init(cls)  # type: ignore[method-assign]  # the specialised one takes its place
        cls.__init__(self, *args, **kwds)

    def serialize(self, buff: Writable) -> None:
        """Write the encoded body to a file-like object.

        Raises:
            SerializationError: a value does not fit its field; the text names the field.
        """
        if _is_generated(type(self)):
            buff.write(message_class(type(self))._encode(self))

    def deserialize(self: _M, data: Buffer) -> _M:
        """Set the fields from the beginning of ``data`` and return self; bytes behind the message are ignored.

        Raises:
            DeserializationError: ``data`` is too short or not such a message. The last string or byte array may be cut
                off: it is shorter then, as in stock.
        """
        if not _is_generated(type(self)):
            return self
        return self._take(message_class(type(self))._decode(bytes(data), 0, len(data)))

    def _take(self: _M, message: Message) -> _M:
        """Take the fields of a message of the same type, and return self."""
        for name in message_class(type(self)).__slots__:
            setattr(self, name, getattr(message, name))
        return self

    def serialize_numpy(self, buff: Writable, numpy: object) -> None:
        """Write the encoded body like :meth:`serialize`, which accepts numpy arrays."""
        Message.serialize(self, buff)  # not the one of a derived class, which may call this

    def deserialize_numpy(self: _M, data: Buffer, numpy: Any) -> _M:
        """Set the fields like :meth:`deserialize`, with numpy arrays of shape (n,) in place of tuples of numbers."""
        view = _module("array_views").genpy_view(numpy)
        return self._take(message_class(type(self))._decode_arrays(bytes(data), 0, len(data), view))

    def _check_types(self, exc: Exception | None = None) -> None:
        """Raise SerializationError if a value does not fit its field."""
        _module("check").check(self, exc)

    def _get_types(self) -> list[str]:
        return self._slot_types

    def __getstate__(self) -> list[Any]:
        return [getattr(self, name) for name in _slots(type(self))]

    def __setstate__(self, state: Any) -> None:
        names = _slots(type(self))
        if isinstance(state, tuple):  # as earlier versions pickled messages
            names, state = zip(*state[1].items(), strict=True)
        for name, value in zip(names, state, strict=False):  # of an older definition, perhaps with fewer fields
            setattr(self, name, value)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, self.__class__):
            return False
        for name in _slots(type(self)):
            own_value, other_value = getattr(self, name, None), getattr(other, name, None)
            if (
                own_value is not other_value
                and (own_value == other_value) is not True
                and not _same(own_value, other_value)
            ):
                return False
        return True

    __hash__ = None  # type: ignore[assignment]  # messages can change

    def __str__(self) -> str:
        text: str = _module("text").format_message(self)
        return text

    __repr__ = __str__


def _same(a: object, b: object) -> bool:
    """Compare values that are perhaps equal though they do not say so: a list and a tuple, arrays of numpy."""
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return tuple(a) == tuple(b)
    equal: Any = a == b
    if isinstance(equal, bool):
        return equal
    return bool(equal.all()) if hasattr(equal, "all") else bool(equal)  # numpy compares element by element


def _is_generated(cls: type[Any]) -> bool:
    """Return whether a class, or one of its bases, was made from a definition."""
    return hasattr(cls, "_slot_types")


def _slots(cls: type[Any]) -> Sequence[str]:
    """Return the names of a message's fields; of a class without a definition, those of its slots."""
    names: Sequence[str] = message_class(cls).__slots__ if _is_generated(cls) else cls.__slots__
    return names


def message_class(cls: type[Any]) -> type[Message]:
    """Return the class that was made from the definition: ``cls`` itself, or its base class if a program derived it."""
    for base in cls.__mro__:
        if "_slot_types" in base.__dict__:
            found: type[Message] = base
            return found
    raise MessageError(f"{cls.__name__} is not a message class")


def nested_classes(cls: type[Message]) -> Mapping[str, type[Message]]:
    """Return the classes of the messages that a message class has in its fields.

    Args:
        cls: a message class.

    Returns:
        The classes by full type name, as ``_slot_types`` has them without their brackets; builtin types are not in it.
    """
    return message_class(cls)._classes


class Service:
    """Base of all service classes: request and response class, and the values for connection headers."""

    _type: ClassVar[str]
    _md5sum: ClassVar[str]
    _full_text: ClassVar[str]
    _request_class: ClassVar[type[Message]]
    _response_class: ClassVar[type[Message]]


class AnyMsg(Message):
    """An encoded message of any type: subscribe with this class to receive any topic without its definitions.

    ``_buff`` holds the encoded body, ``_connection_header`` the publisher's header.

    Args:
        buff: the body; None: there is none yet, and the message cannot be sent.
        connection_header: the header.

    Raises:
        TypeError: the body is text.
    """

    __slots__ = ["_buff"]

    _type: ClassVar[str] = "*"
    _md5sum: ClassVar[str] = "*"
    _full_text: ClassVar[str] = ""
    _has_header: ClassVar[bool] = False
    _slot_types: ClassVar[list[str]] = []
    _fixed_size: ClassVar[int | None] = None
    _min_size: ClassVar[int] = 0
    _weight: ClassVar[int] = 64
    _classes: ClassVar[dict[str, type[Message]]] = {}

    def __init__(self, buff: Buffer | None = None, connection_header: dict[str, str] | None = None) -> None:
        if isinstance(buff, str):
            raise TypeError(f"AnyMsg holds bytes, not {buff!r:.80}")
        self._buff: bytes = buff  # type: ignore[assignment]  # few read one that was neither received nor filled
        self._connection_header = connection_header

    # Functions as the generated ones, which mypy takes for methods.

    @staticmethod
    def _decode(buffer: bytes, start: int, end: int, exact: bool = False) -> AnyMsg:
        return AnyMsg(buffer[start:end])

    @staticmethod
    def _encode(message: AnyMsg) -> bytes:  # type: ignore[override]
        return bytes(_body(message))

    @staticmethod
    def _copy(message: AnyMsg) -> AnyMsg:  # type: ignore[override]
        return AnyMsg(bytes(_body(message)))

    @staticmethod
    def _encode_frame(message: AnyMsg) -> Frame:  # type: ignore[override]
        body = message._buff
        if body is None:
            _body(message)
        size = len(body).to_bytes(4, "little")
        return [size, body] if len(body) >= 16384 else size + body

    def serialize(self, buff: Writable) -> None:
        """Write the received bytes to a file-like object.

        Raises:
            SerializationError: there are none.
        """
        buff.write(_body(self))

    def deserialize(self, data: Buffer) -> AnyMsg:
        """Keep ``data`` and return self."""
        self._buff = bytes(data)
        return self

    def __str__(self) -> str:
        return object.__repr__(self)

    __repr__ = __str__

    def decode(self, cls: type[Message] | None = None) -> Message:
        """Return the decoded message.

        Args:
            cls: its class; None: a class is made from the connection header. For many messages of one connection,
                take one class from a :class:`pyros1.msgs.DefinitionCache`.

        Raises:
            DefinitionError, UnknownTypeError: the header lacks type or definition, or the definition is wrong, and the
                type that is installed here cannot take its place.
            DeserializationError: the bytes are not a message of this type.
            SerializationError: there are none.
        """
        if cls is None:
            header = self._connection_header or {}
            if "type" not in header:
                raise DefinitionError("the connection header carries no type")
            text = header.get("message_definition", "")
            cls = _module("nonstandard_definitions").find_class(
                header["type"], header.get("md5sum", ""), text, by_name=True
            )
        body = _body(self)
        message: Message = cls._decode(body, 0, len(body))
        message._connection_header = self._connection_header
        return message


def _body(message: AnyMsg) -> bytes:
    body = message._buff
    if body is None:
        raise SerializationError("this AnyMsg has no bytes: it was neither received nor filled")
    return body
