"""The interface of all buffers: lookups, `transform` for data of registered types, and conversions between types.

Packages such as tf2_geometry_msgs register their types when they are imported.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import rospy

from pyros1.msgs.std_msgs.msg import Header

_NO_WAIT = rospy.Duration(0.0)


class BufferInterface:
    """Base class of buffers.

    Attributes:
        registration: the types that `transform` supports.
    """

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(self, object_stamped: Any, target_frame: str, timeout: Any = _NO_WAIT, new_type: Any = None) -> Any:
        """Transform data with a header to another frame, at the time of its header.

        Args:
            object_stamped: the data, of a registered type.
            target_frame: name of the other frame.
            timeout: maximum Duration to wait for the transform.
            new_type: type to which to convert the result; None to keep the data's type.

        Raises:
            TypeException: the type is not registered.
            TransformException: there is no such transform.
        """
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        transformed = do_transform(
            object_stamped, self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        )
        return transformed if not new_type else convert(transformed, new_type)

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
        new_type: Any = None,
    ) -> Any:
        """Transform data to another frame at another time, if ``fixed_frame`` does not move. See `transform`."""
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        transformed = do_transform(
            object_stamped,
            self.lookup_transform_full(target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout),
        )
        return transformed if not new_type else convert(transformed, new_type)

    def lookup_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``; to be overridden."""
        raise NotImplementedException()

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
    ) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``, each at its own time; to be overridden."""
        raise NotImplementedException()

    def can_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT) -> Any:
        """Return whether `lookup_transform` would succeed; to be overridden."""
        raise NotImplementedException()

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
    ) -> Any:
        """Return whether `lookup_transform_full` would succeed; to be overridden."""
        raise NotImplementedException()


def Stamped(obj: Any, stamp: Any, frame_id: str) -> Any:
    """Add a header with a time and a frame to an object, and return it."""
    obj.header = Header(frame_id=frame_id, stamp=stamp)
    return obj


class TypeException(Exception):
    """A type is not registered."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(Exception):
    """A buffer does not implement a method."""

    def __init__(self) -> None:
        super().__init__()
        self.errstr = "CanTransform or LookupTransform not implemented"


class TransformRegistration:
    """The types that can be transformed in this process, with the functions that transform them."""

    __type_map: dict[Any, Callable[[Any, Any], Any]] = {}

    def print_me(self) -> None:
        """Print the types."""
        print(self.__type_map)

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register a type, with a function that transforms an object by a geometry_msgs/TransformStamped."""
        self.__type_map[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return the function that transforms a type; raises TypeException if there is none."""
        return _get_registered(self.__type_map, key)


class ConvertRegistration:
    """The conversions between types in this process: direct ones, and ones from and to messages."""

    __to_msg_map: dict[Any, Callable[[Any], Any]] = {}
    __from_msg_map: dict[Any, Callable[[Any], Any]] = {}
    __convert_map: dict[Any, Callable[[Any], Any]] = {}

    def add_from_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register a function that creates an object of type ``key`` from a message."""
        self.__from_msg_map[key] = callback

    def add_to_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register a function that creates a message from an object of type ``key``."""
        self.__to_msg_map[key] = callback

    def add_convert(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register a direct conversion, for a pair of types (from, to)."""
        self.__convert_map[key] = callback

    def get_from_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return the function that creates an object of type ``key`` from a message; raises TypeException."""
        return _get_registered(self.__from_msg_map, key)

    def get_to_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return the function that creates a message from an object of type ``key``; raises TypeException."""
        return _get_registered(self.__to_msg_map, key)

    def get_convert(self, key: Any) -> Callable[[Any], Any]:
        """Return the direct conversion for a pair of types (from, to); raises TypeException."""
        return _get_registered(self.__convert_map, key)


def _get_registered(functions: dict[Any, Callable[..., Any]], key: Any) -> Callable[..., Any]:
    try:
        return functions[key]
    except KeyError:
        raise TypeException(f"Type {key} if not loaded or supported") from None


def convert(a: Any, b_type: Any) -> Any:
    """Convert an object to another type, directly or through a message; return a copy if it already has that type.

    Raises:
        TypeException: there is no such conversion.
    """
    conversions = ConvertRegistration()
    try:
        return conversions.get_convert((type(a), b_type))(a)
    except TypeException:
        if isinstance(a, b_type):
            return deepcopy(a)
    to_message = conversions.get_to_msg(type(a))
    return conversions.get_from_msg(b_type)(to_message(a))
