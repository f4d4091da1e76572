"""tf2_py, by pyros1: the buffer of transforms and its exceptions (https://wiki.ros.org/tf2_py)."""

from pyros1.tf.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
from tf2_py._tf2 import BufferCore
