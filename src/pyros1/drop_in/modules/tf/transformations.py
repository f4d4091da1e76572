"""tf.transformations, by pyros1: calculations with rotations and homogeneous matrices (https://wiki.ros.org/tf)."""

import math

import numpy

from pyros1.tf.rotation import EPS as _EPS
from pyros1.tf.transformations import *  # noqa: F403  like stock: all its functions

_NEXT_AXIS = [1, 2, 0, 1]
# Name of an axis sequence, such as "sxyz" -> index of the first axis, and three flags (0 or 1): whether the axes are in
# odd (not cyclic) order, whether the first axis is repeated at the end, and whether the axes rotate.
_AXES2TUPLE = {
    frame
    + "xyz"[first]
    + "xyz"[_NEXT_AXIS[first + odd]]
    + "xyz"[first if repeats_first else _NEXT_AXIS[first - odd + 1]]: (
        first,
        odd,
        repeats_first,
        0,
    )
    for frame in "s"
    for first in range(3)
    for odd in (0, 1)
    for repeats_first in (0, 1)
}
# For rotating axes, the angles apply in reverse order: the name is read from its end.
_AXES2TUPLE |= {"r" + name[:0:-1]: (*parts[:3], 1) for name, parts in _AXES2TUPLE.items()}
_TUPLE2AXES = {parts: name for name, parts in _AXES2TUPLE.items()}
