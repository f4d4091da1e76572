"""What a lookup can fail of; names and texts are tf2's."""

from __future__ import annotations

from pyros1.errors import Error


class TransformException(Error):
    """Base of all: the transform is not to be had."""


class LookupException(TransformException):
    """A frame does not exist, or the tree has a loop."""


class ConnectivityException(TransformException):
    """Both frames exist, but in different trees."""


class ExtrapolationException(TransformException):
    """The time lies before or behind the data of some frame on the way."""


class InvalidArgumentException(TransformException):
    """A frame's name is empty or begins with a slash."""


class TimeoutException(TransformException):
    """No answer came in time."""
