"""Determines which values have the same bytes in ROS 1 and in CDR. No I/O."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from pyros1.ros2_types.transcoding.plan import Array, Changed, Node, Numbers, Record, Text

_MAX_NUMBERS = 1000


def aligned(position: int, width: int) -> int:
    """Return the first position, from ``position`` on, at which CDR can place a number of ``width`` bytes."""
    return -(-position // width) * width


def minimum_size(node: Node, *, in_ros1: bool) -> int:
    """Return the minimum size of a value in ROS 1, or in CDR without padding; 0 if that side lacks the value."""
    if not (node.in_ros1 if in_ros1 else node.in_ros2):
        return 0
    if isinstance(node, Numbers):
        return node.width * node.amount
    if isinstance(node, Changed):
        return struct.calcsize("<" + (node.ros1 if in_ros1 else node.ros2))
    if isinstance(node, Text):
        return 4
    if isinstance(node, Array):
        count = node.ros1 if in_ros1 else node.ros2
        assert count is not None
        return 4 if count < 0 else count * minimum_size(node.element, in_ros1=in_ros1)
    return sum(minimum_size(child, in_ros1=in_ros1) for child in node.nodes)


def weight(node: Node) -> int:
    """Return the number of values in an element, including those in fixed arrays; at least 1."""
    if isinstance(node, Array):
        return max(1, node.ros1 or 1, node.ros2 or 1) * weight(node.element)
    if isinstance(node, Record):
        return 1 + sum(map(weight, node.nodes))
    return 1


def bulk_layout(node: Node, *, source_is_cdr: bool, skip: bool, residues: Iterable[int]) -> tuple[int, int] | None:
    """Return the size and the alignment of array elements that have the same bytes on both sides.

    Args:
        node: an element.
        source_is_cdr: whether the source is CDR.
        skip: whether to only skip the elements, so that the target does not matter.
        residues: possible positions in CDR, modulo 8, before the padding that precedes the first element.

    Returns:
        None if the elements have to be converted one by one.
    """
    numbers: list[tuple[int, int]] = []
    if not _collect(node, numbers, source_is_cdr=source_is_cdr, skip=skip) or not numbers:
        return None
    size = sum(width * count for width, count in numbers)
    alignment = numbers[0][0]
    if skip and not source_is_cdr:
        return size, 1
    for residue in residues:
        start = position = aligned(residue, alignment)
        for _ in range(8):  # after that, positions modulo 8 repeat
            for width, count in numbers:
                if position % width:
                    return None
                position += width * count
            if (position - start) % 8 == 0:
                break
    return size, alignment


def _collect(node: Node, numbers: list[tuple[int, int]], *, source_is_cdr: bool, skip: bool) -> bool:
    """Append the width and count of a value's numbers. Return False if they are too many, or if it contains anything
    else; without ``skip``, also if one side lacks a number.
    """
    if isinstance(node, Numbers):
        if not (node.in_ros2 if source_is_cdr else node.in_ros1):
            return skip
        if node.amount:
            numbers.append((node.width, node.amount))
        return len(numbers) <= _MAX_NUMBERS
    if isinstance(node, Changed):
        if skip:
            numbers.append((struct.calcsize("<" + (node.ros2 if source_is_cdr else node.ros1)), 1))
        return skip and len(numbers) <= _MAX_NUMBERS
    if not isinstance(node, Record):
        return False
    order = node.ros2 if source_is_cdr else node.ros1
    if not skip and node.ros1 != node.ros2:
        return False
    return all(_collect(node.nodes[index], numbers, source_is_cdr=source_is_cdr, skip=skip) for index in order or ())
