"""Converts encoded messages between ROS 1 and CDR, the encoding of ROS 2, without decoding them into objects.

CDR here means what ROS 2 middleware sends: XCDR version 1 with its header of 4 bytes.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from pyros1.ground.errors import DefinitionError, MessageError
from pyros1.msgs.spec import MessageSpec
from pyros1.ros2_types.mapping import STANDARD_FIELDS, FieldRules
from pyros1.ros2_types.model import Types
from pyros1.ros2_types.transcoding.plan import Planner
from pyros1.ros2_types.transcoding.source import Generator
from pyros1.ros2_types.transcoding.swap import to_little_endian
from pyros1.ros2_types.transcoding.text import ERRORS

_BIG_ENDIAN, _LITTLE_ENDIAN = b"\0\0", b"\0\1"
_HEADER_SIZE = 4


class Transcoder:
    """Converts the messages of one ROS 1 type to those of one ROS 2 type, and back.

    Fields are matched by name, unless there is a rule; so are the fields of nested types, whatever the types' names. A
    field that the target lacks is dropped; one that the source lacks is zero or empty. The ``seq`` of ROS 1 headers is
    an exception: unless given, each transcoder counts it up from 1; all headers of a message get the same number.

    Args:
        ros1_name: full name of the ROS 1 type, ``package/Type``.
        specs: the ROS 1 types by full name, including all that it uses.
        ros2_name: full name of the ROS 2 type, ``package/msg/Type``.
        types: the ROS 2 types, including all that it uses.
        rules: the matching fields of types whose fields are not matched by name.

    Attributes:
        only_ros1: dotted names of the fields that ROS 2's type lacks, for example ``pose.covariance``; without the
            fields inside such fields, and without the ``seq`` of headers.
        only_ros2: dotted names of the fields that ROS 1's type lacks.

    Integers of different sizes are converted if one type can hold all values of the other, and so are floats; a value
    that the target's type cannot hold is an error.

    Raises:
        DefinitionError: the types of two matching fields cannot be converted, a rule names a field that does not exist,
            or a type is unknown or too large.
    """

    def __init__(
        self,
        ros1_name: str,
        specs: Mapping[str, MessageSpec],
        ros2_name: str,
        types: Types,
        rules: FieldRules = STANDARD_FIELDS,
    ) -> None:
        self._ros1_name, self._ros2_name, self._types = ros1_name, ros2_name, types
        planner = Planner(specs, types, rules)
        try:
            record = planner.record(ros1_name, ros2_name)
            self._to_cdr = Generator(to_cdr=True).compile(record)
            self._from_cdr = Generator(to_cdr=False).compile(record)
        except DefinitionError as error:
            raise DefinitionError(f"cannot convert {ros1_name:.200} and {ros2_name:.200}: {error}") from None
        self.only_ros1: list[str] = planner.only_ros1
        self.only_ros2: list[str] = planner.only_ros2
        self._seqs = itertools.count(1)

    def to_cdr(self, body: bytes | memoryview) -> bytes:
        """Convert a ROS 1 message to CDR. Bytes after the message are ignored.

        Args:
            body: the message, without a length prefix.

        Returns:
            Little-endian CDR with its header.

        Raises:
            MessageError: the bytes are not such a message, an array or string is too long for ROS 2's type, or its type
                cannot hold a number.
        """
        try:
            return self._to_cdr(body if body.__class__ is bytes else memoryview(body).cast("B"), 0)
        except ERRORS as error:
            raise self._message_error(self._ros1_name, error) from None

    def from_cdr(self, data: bytes | memoryview, seq: int | None = None) -> bytes:
        """Convert a CDR message to ROS 1. Bytes after the message are ignored.

        Args:
            data: the message with its header, in either byte order.
            seq: the ``seq`` of its headers; None to count messages.

        Returns:
            The ROS 1 message, without a length prefix.

        Raises:
            MessageError: the bytes are not such a message, an array's length differs from ROS 1's type, or that type
                cannot hold a number.
        """
        try:
            data = data if data.__class__ is bytes else memoryview(data).cast("B")
            order = data[:2]
            if order != _LITTLE_ENDIAN or len(data) < _HEADER_SIZE:
                if order != _BIG_ENDIAN or len(data) < _HEADER_SIZE:
                    raise MessageError(f"its header {bytes(data[:4]).hex()} is not that of CDR")
                data = to_little_endian(data, self._ros2_name, self._types)
            return self._from_cdr(data, (next(self._seqs) if seq is None else seq) & 0xFFFFFFFF)
        except ERRORS as error:
            raise self._message_error(self._ros2_name, error) from None

    @staticmethod
    def _message_error(name: str, error: Exception) -> MessageError:
        reason = error if isinstance(error, MessageError) else "it ends too early, or a length in it is wrong"
        return MessageError(f"cannot convert a {name}: {reason}")
