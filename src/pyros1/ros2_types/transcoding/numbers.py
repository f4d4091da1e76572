"""Converts numbers whose types differ between ROS 1 and ROS 2, without loss. No I/O."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from functools import partial

from pyros1.ground.errors import DefinitionError, MessageError
from pyros1.ros2_types.log_levels import ValueRule

Convert = Callable[[float], float]
"""Converts a value; raises MessageError if the other type cannot hold it."""

_SMALL_INTEGERS = frozenset(["byte", "char", "int8", "uint8"])
_RANGES = {
    "byte": (-128, 127),  # only in ROS 1; in ROS 2, from 0 to 255, see `conversion`
    "char": (0, 255),
    **{f"int{bits}": (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
}
_FLOATS = ("float32", "float64")


def conversion(base1: str, base2: str, label: str, value_rule: ValueRule | None) -> tuple[Convert, Convert] | None:
    """Return how to convert a number's values to ROS 2 and back; None if their bytes are the same.

    Args:
        base1: its type in ROS 1.
        base2: its type in ROS 2.
        label: the field's name, for error messages.
        value_rule: how values are converted; None to keep them.

    Raises:
        DefinitionError: neither type can hold all values of the other.
    """
    if value_rule is not None and base1 in _SMALL_INTEGERS and base2 in _SMALL_INTEGERS:
        return value_rule.to_ros2.__getitem__, value_rule.to_ros1.__getitem__  # type: ignore[return-value]
    if base1 == base2 or (base1 in _SMALL_INTEGERS and base2 in _SMALL_INTEGERS):
        return None
    range1, range2 = _RANGES.get(base1), _RANGES.get("uint8" if base2 == "byte" else base2)
    if range1 and range2:
        if (range1[0] <= range2[0] and range2[1] <= range1[1]) or (range2[0] <= range1[0] and range1[1] <= range2[1]):
            return partial(_checked, range2, base2, label), partial(_checked, range1, base1, label)
        raise DefinitionError(
            f"{base1} of ROS 1 is not {base2} of ROS 2, and neither can hold all values of the other", label
        )
    if base1 in _FLOATS and base2 in _FLOATS:
        return (_same, partial(_short, label)) if base2 == "float64" else (partial(_short, label), _same)
    raise DefinitionError(f"{base1} of ROS 1 is not {base2} of ROS 2", label)


def _checked(limits: tuple[int, int], base: str, label: str, value: float) -> float:
    if not limits[0] <= value <= limits[1]:
        raise MessageError(f"{label} is {value}, which is not a value of {base}")
    return value


def _same(value: float) -> float:
    return value


def _short(label: str, value: float) -> float:
    try:
        (short,) = struct.unpack("<f", struct.pack("<f", value))
    except OverflowError:
        short = math.inf
    if short != value and not math.isnan(value):
        raise MessageError(f"{label} is {value}, which float32 cannot hold without loss")
    return value
