"""Exceptions of rospy (https://wiki.ros.org/rospy/Overview/Exceptions)."""


class ROSException(Exception):
    """Base class of exceptions for programs."""


class ROSSerializationException(ROSException):
    """A message cannot be encoded."""


class ROSInitException(ROSException):
    """The node has not been started."""


class ROSInterruptException(ROSException, KeyboardInterrupt):
    """A wait was interrupted because the node is shutting down."""


class ROSTimeMovedBackwardsException(ROSInterruptException):
    """Simulated time jumped back during a sleep.

    Attributes:
        time: how far time jumped back.
    """

    def __init__(self, time: object) -> None:
        self.time = time
        super().__init__("ROS time moved backwards")


class ROSInternalException(Exception):
    """Base class of internal exceptions of rospy."""


class TransportException(ROSInternalException):
    """Base class of transport errors."""


class TransportTerminated(TransportException):
    """A connection was closed."""


class TransportInitError(TransportException):
    """A connection cannot be established."""
