"""Lists all pairs of installed types that a bridge to ROS 2 knows, as text."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import load_message
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2_types.model import Types
from pyros1.ros2_types.type_hash import type_hash


class ListedPair(NamedTuple):
    """A pair of types.

    Attributes:
        ros1, ros2: the names; empty on the side that has no such type.
        note: why there is no pair, or which side's definition is used; empty if both sides have their own.
    """

    ros1: str
    ros2: str
    note: str = ""

    def __str__(self) -> str:
        pair = f"{self.ros1} <-> {self.ros2}" if self.ros1 and self.ros2 else f"{self.ros1 or self.ros2}"
        return f"{pair}: {self.note}" if self.note else pair


def list_messages(
    pairs: TypePairs, installed: Iterable[str], there: Types, wanted: Collection[str] = ()
) -> Iterator[ListedPair]:
    """Yield the pairs of message types; types that only ROS 2 has come last.

    Args:
        pairs: finds the types.
        installed: the names of the ROS 1 types.
        there: the types of a ROS 2 distribution.
        wanted: the ROS 1 or ROS 2 names of the types to list; empty for all.
    """
    seen: set[str] = set()
    for name in installed:
        ros2 = _name(pairs.name_in_ros2, name)
        seen.add(ros2)
        if not wanted or name in wanted or ros2 in wanted:
            try:
                message_class = load_message(name)
                ros2 = pairs.for_ros1(name, message_class._md5sum, message_class._full_text).ros2
                yield ListedPair(name, ros2, "" if ros2 in there else "as it is defined in ROS 1")
            except Error as error:
                yield ListedPair(name, "", one_line(error))
    for ros2 in there:
        if ros2 not in seen and (not wanted or ros2 in wanted):
            try:
                yield ListedPair(pairs.for_ros2(ros2, type_hash(ros2, there)).ros1, ros2, "as it is defined in ROS 2")
            except Error as error:
                yield ListedPair("", ros2, one_line(error))


def list_services(pairs: TypePairs, installed: Iterable[str], wanted: Collection[str] = ()) -> Iterator[ListedPair]:
    """Yield the pairs of service types. Services that only ROS 2 has are not known here.

    Args:
        pairs: finds the types.
        installed: the names of the ROS 1 types.
        wanted: the ROS 1 or ROS 2 names of the types to list; empty for all.
    """
    for name in installed:
        if not wanted or name in wanted or name.replace("/", "/srv/") in wanted:
            try:
                yield ListedPair(name, pairs.service_for_ros1(name, "*").ros2)
            except Error as error:
                yield ListedPair(name, "", one_line(error))


def _name(find: Callable[[str], str], name: str) -> str:
    try:
        return find(name)
    except Error:
        return ""
