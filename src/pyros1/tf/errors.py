"""The exceptions that lookups raise, with tf2's names and messages."""

from __future__ import annotations

from pyros1.ground.errors import Error


class TransformException(Error):
    """Base class: the transform is not available."""


class LookupException(TransformException):
    """A frame does not exist, or the tree has a loop."""


class ConnectivityException(TransformException):
    """Both frames exist, but in different trees."""


class ExtrapolationException(TransformException):
    """The time is before or after the data of a frame on the path."""


class InvalidArgumentException(TransformException):
    """A frame's name is empty or begins with a slash."""


class TimeoutException(TransformException):
    """No response arrived in time."""
